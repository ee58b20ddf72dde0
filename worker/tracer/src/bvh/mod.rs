//! The ray engine: which triangle a ray meets first, and whether it meets any.
//!
//! [`Bvh`] is a bounding volume hierarchy with eight children per node and up to eight triangles per leaf. `split` builds
//! a binary tree by the surface area heuristic, obvhs improves it by reinsertion, `collapse` makes it eight wide,
//! `layout` writes the arrays. `traverse` takes single rays through them, `packet` bundles of coherent ones, both over
//! `lanes`, which is AVX2 where the processor has it and plain Rust elsewhere.
//!
//! **Hits do not depend on the path.** `triangle` defines whether and where a ray hits a triangle by the two alone, in
//! arithmetic that is the same per lane everywhere, with no fused multiply-add. Boxes only ever cull what that test
//! rejects. Of equally near hits the smallest triangle index wins. So hierarchy, instruction set and packets change how
//! long an answer takes, never a bit of it.

mod bounds;
mod collapse;
mod lanes;
mod layout;
mod memory;
mod node;
mod octet;
mod packet;
mod ray;
mod split;
mod stack;
mod stream;
#[cfg(test)]
mod tests;
mod traverse;
mod triangle;

pub use ray::{Hit, Ray};

use glam::Vec3;
use lanes::portable::Portable;
use layout::Layout;

#[cfg(target_arch = "x86_64")]
use lanes::avx2::Avx2;

/// A hierarchy over a triangle mesh. It allocates nothing per ray and may be shared by threads.
///
/// A ray never slips between two triangles that share two vertices. Triangles count from both sides. There is no
/// smallest or largest scale between 1e-12 and 1e12.
pub struct Bvh {
    layout: Layout,
    #[cfg(target_arch = "x86_64")]
    avx2: Option<Avx2>,
}

impl Bvh {
    /// Builds the hierarchy over triangles given by their three vertices, in any unit of length.
    ///
    /// Triangles without an area (less than 1e-14 of the product of two sides), or with a coordinate that is not finite
    /// or beyond 1e12, keep their index and are never hit. So are all after the first 2^28.
    #[must_use]
    pub fn build(triangles: &[[Vec3; 3]]) -> Self {
        Self {
            layout: layout::layout(triangles),
            #[cfg(target_arch = "x86_64")]
            avx2: Avx2::detect(),
        }
    }

    /// The first triangle that the ray meets.
    #[must_use]
    #[inline]
    pub fn closest(&self, ray: &Ray) -> Option<Hit> {
        #[cfg(target_arch = "x86_64")]
        if let Some(avx2) = self.avx2 {
            // SAFETY: the token proves that the processor has what the function enables.
            #[allow(unsafe_code)]
            return unsafe { closest_avx2(avx2, &self.layout, ray) };
        }
        closest_portable(&self.layout, ray)
    }

    /// Whether the ray meets any triangle: quicker than, and always the same as, `closest(ray).is_some()`.
    #[must_use]
    #[inline]
    pub fn occluded(&self, ray: &Ray) -> bool {
        #[cfg(target_arch = "x86_64")]
        if let Some(avx2) = self.avx2 {
            // SAFETY: as in `closest`.
            #[allow(unsafe_code)]
            return unsafe { occluded_avx2(avx2, &self.layout, ray) };
        }
        occluded_portable(&self.layout, ray)
    }

    /// The first triangle that each ray meets: the same as [`Bvh::closest`], several times faster where 16 consecutive
    /// rays (16 k to 16 k + 15) start and run close together, as those of a tile of 4 x 4 pixels, or of the samples of
    /// one pixel. Fills the elements of `hits` that have a ray.
    pub fn closest_packet(&self, rays: &[Ray], hits: &mut [Option<Hit>]) {
        for (rays, hits) in rays.chunks(packet::PACKET).zip(hits.chunks_mut(packet::PACKET)) {
            if !self.closest_coherent(rays, hits) {
                for (ray, hit) in rays.iter().zip(hits) {
                    *hit = self.closest(ray);
                }
            }
        }
    }

    /// Whether each ray meets any triangle: the same as [`Bvh::occluded`], faster for rays as [`Bvh::closest_packet`]
    /// wants them. Fills the elements of `blocked` that have a ray.
    pub fn occluded_packet(&self, rays: &[Ray], blocked: &mut [bool]) {
        for (rays, blocked) in rays.chunks(packet::PACKET).zip(blocked.chunks_mut(packet::PACKET)) {
            if !self.occluded_coherent(rays, blocked) {
                for (ray, blocked) in rays.iter().zip(blocked) {
                    *blocked = self.occluded(ray);
                }
            }
        }
    }

    /// The first triangle that each ray meets: the same as [`Bvh::closest`], faster for rays that start close together
    /// and mostly meet nothing. Fills the elements of `hits` that have a ray.
    pub fn closest_stream(&self, rays: &[Ray], hits: &mut [Option<Hit>]) {
        for (rays, hits) in rays.chunks(stream::STREAM).zip(hits.chunks_mut(stream::STREAM)) {
            #[cfg(target_arch = "x86_64")]
            if let Some(avx2) = self.avx2 {
                // SAFETY: as in `closest`.
                #[allow(unsafe_code)]
                unsafe {
                    stream_avx2(avx2, &self.layout, rays, hits);
                }
                continue;
            }
            stream_portable(&self.layout, rays, hits);
        }
    }

    /// As [`Bvh::closest_coherent`].
    fn occluded_coherent(&self, rays: &[Ray], blocked: &mut [bool]) -> bool {
        if rays.len() < packet::PACKET / 4 {
            return false;
        }
        #[cfg(target_arch = "x86_64")]
        if let Some(avx2) = self.avx2 {
            // SAFETY: as in `closest`.
            #[allow(unsafe_code)]
            return unsafe { occluded_packet_avx2(avx2, &self.layout, rays, blocked) };
        }
        occluded_packet_portable(&self.layout, rays, blocked)
    }

    /// False, and nothing done, where the rays are too few or too far apart to share a walk.
    fn closest_coherent(&self, rays: &[Ray], hits: &mut [Option<Hit>]) -> bool {
        if rays.len() < packet::PACKET / 4 {
            return false;
        }
        #[cfg(target_arch = "x86_64")]
        if let Some(avx2) = self.avx2 {
            // SAFETY: as in `closest`.
            #[allow(unsafe_code)]
            return unsafe { packet_avx2(avx2, &self.layout, rays, hits) };
        }
        packet_portable(&self.layout, rays, hits)
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
fn closest_avx2(avx2: Avx2, layout: &Layout, ray: &Ray) -> Option<Hit> {
    traverse::closest(avx2, &layout.nodes, &layout.leaves, ray)
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
fn occluded_avx2(avx2: Avx2, layout: &Layout, ray: &Ray) -> bool {
    traverse::occluded(avx2, &layout.nodes, &layout.leaves, ray)
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
fn packet_avx2(avx2: Avx2, layout: &Layout, rays: &[Ray], hits: &mut [Option<Hit>]) -> bool {
    packet::closest(avx2, &layout.nodes, &layout.leaves, layout.extent, rays, hits)
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
fn occluded_packet_avx2(avx2: Avx2, layout: &Layout, rays: &[Ray], blocked: &mut [bool]) -> bool {
    packet::occluded(avx2, &layout.nodes, &layout.leaves, layout.extent, rays, blocked)
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
fn stream_avx2(avx2: Avx2, layout: &Layout, rays: &[Ray], hits: &mut [Option<Hit>]) {
    stream::closest(avx2, &layout.nodes, &layout.leaves, rays, hits);
}

// Kept out of line, so that the fast path above carries none of their registers.
#[inline(never)]
fn closest_portable(layout: &Layout, ray: &Ray) -> Option<Hit> {
    traverse::closest(Portable, &layout.nodes, &layout.leaves, ray)
}

#[inline(never)]
fn occluded_portable(layout: &Layout, ray: &Ray) -> bool {
    traverse::occluded(Portable, &layout.nodes, &layout.leaves, ray)
}

#[inline(never)]
fn packet_portable(layout: &Layout, rays: &[Ray], hits: &mut [Option<Hit>]) -> bool {
    packet::closest(Portable, &layout.nodes, &layout.leaves, layout.extent, rays, hits)
}

#[inline(never)]
fn occluded_packet_portable(layout: &Layout, rays: &[Ray], blocked: &mut [bool]) -> bool {
    packet::occluded(Portable, &layout.nodes, &layout.leaves, layout.extent, rays, blocked)
}

#[inline(never)]
fn stream_portable(layout: &Layout, rays: &[Ray], hits: &mut [Option<Hit>]) {
    stream::closest(Portable, &layout.nodes, &layout.leaves, rays, hits);
}
