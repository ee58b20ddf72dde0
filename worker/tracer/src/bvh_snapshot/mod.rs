#![allow(unsafe_code, missing_docs, warnings, clippy::all, clippy::undocumented_unsafe_blocks, clippy::unwrap_used)]
#![allow(unsafe_code)]
mod bounds; mod build; mod collapse; mod lanes; mod node; mod ray; mod stack; mod traverse; mod triangle;
pub use ray::{Hit, Ray};
pub use build::env;
#[cfg(stats)] pub use traverse::COUNT;
use lanes::avx2::Avx2; use lanes::portable::Portable;
use node::*;
use glam::Vec3;

pub struct Bvh { nodes: Vec<Node>, blocks: Vec<Block>, isa: Option<Avx2> }

#[allow(unsafe_code)]
#[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt,fma")]
fn closest_avx2(isa: Avx2, b: &Bvh, r: &Ray) -> Option<Hit> { traverse::closest(isa, &b.nodes, &b.blocks, r) }
#[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt,fma")]
fn occluded_avx2(isa: Avx2, b: &Bvh, r: &Ray) -> bool { traverse::occluded(isa, &b.nodes, &b.blocks, r) }

impl Bvh {
    pub fn build(t: &[[Vec3; 3]]) -> Self { let (nodes, blocks) = build::build(t); Self { nodes, blocks, isa: Avx2::detect() } }
    pub fn closest(&self, r: &Ray) -> Option<Hit> {
        match self.isa { Some(i) => unsafe { closest_avx2(i, self, r) }, None => traverse::closest(Portable, &self.nodes, &self.blocks, r) }
    }
    pub fn occluded(&self, r: &Ray) -> bool {
        match self.isa { Some(i) => unsafe { occluded_avx2(i, self, r) }, None => traverse::occluded(Portable, &self.nodes, &self.blocks, r) }
    }
    pub fn portable(&mut self) { self.isa = None; }
    pub fn sizes(&self) -> (usize, usize) { (self.nodes.len(), self.blocks.len()) }
}

