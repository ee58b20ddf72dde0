use super::bounds::Bounds;
use super::collapse::{Costs, Plan, Slot};
use super::node::*;
use glam::Vec3;
use obvhs::{BvhBuildParams, aabb::Aabb, bvh2::builder::build_bvh2, ploc::{PlocBuilder, PlocSearchDistance, SortPrecision}, bvh2::reinsertion::ReinsertionOptimizer};

pub fn env(n: &str, d: f32) -> f32 { std::env::var(n).ok().and_then(|s| s.parse().ok()).unwrap_or(d) }

pub(super) fn build(triangles: &[[Vec3; 3]]) -> (Vec<Node>, Vec<Block>) {
    let live: Vec<u32> = (0..triangles.len() as u32).filter(|&i| {
        let [a, b, c] = triangles[i as usize].map(|v| v.as_dvec3());
        let n = (b - a).cross(c - a);
        n.length_squared() > 0.0
    }).collect();
    if live.is_empty() { return (vec![Node::EMPTY], vec![]); }
    let boxes: Vec<Aabb> = live.iter().map(|&i| { let b = Bounds::padded(&triangles[i as usize]); Aabb::new(b.low.into(), b.high.into()) }).collect();
    let mut d = std::time::Duration::default();
    let preset = env("PRESET", 5.0) as i32;
    let mut p = match preset { 1 => BvhBuildParams::fastest_build(), 2 => BvhBuildParams::very_fast_build(), 3=>BvhBuildParams::fast_build(), 4=>BvhBuildParams::medium_build(), 5=>BvhBuildParams::slow_build(), _=>BvhBuildParams::very_slow_build() };
    p.pre_split = false;
    p.max_prims_per_leaf = 1;
    p.post_collapse_reinsertion_batch_ratio_multiplier = 0.0;
    if let Ok(s) = std::env::var("REINS") { p.reinsertion_batch_ratio = s.parse().unwrap(); }
    let t = std::time::Instant::now();
    let mut tree = build_bvh2(&boxes, p, &mut d);
    if env("SAH",0.0)>1.0 { ReinsertionOptimizer::default().run(&mut tree, p.reinsertion_batch_ratio, None); }
    if env("VERB", 0.0) > 0.0 { eprintln!("bvh2 {:?}", t.elapsed()); }
    let t = std::time::Instant::now();
    let plan = Plan::new(&tree, Costs { node: env("CNODE", 1.0), block: env("CBLOCK", 1.0) });
    if env("VERB", 0.0) > 0.0 { eprintln!("plan {:?}", t.elapsed()); }
    let t = std::time::Instant::now();
    let mut nodes = vec![]; let mut blocks = vec![];
    let mut make_block = |i: usize, blocks: &mut Vec<Block>| {
        let mut b = Block::EMPTY;
        for (l, k) in plan.triangles(i).into_iter().enumerate() {
            let t = live[k as usize];
            b.triangles[l] = t;
            for v in 0..3 { for a in 0..3 { b.vertices[v * 3 + a][l] = triangles[t as usize][v][a]; } }
        }
        blocks.push(b);
        (blocks.len() - 1) as u32 | Child::LEAF
    };
    let set = |n: &mut Node, s: usize, b: Bounds| { for a in 0..3 { n.planes[a*2][s] = b.low[a]; n.planes[a*2+1][s] = b.high[a]; } };
    if plan.root_is_leaf() {
        let mut n = Node::EMPTY;
        set(&mut n, 0, plan.bounds(0));
        n.children[0] = make_block(0, &mut blocks);
        return (vec![n], blocks);
    }
    // depth first; (binary node, parent wide, slot)
    let mut todo = vec![(0usize, usize::MAX, 0usize)];
    while let Some((i, parent, slot)) = todo.pop() {
        let me = nodes.len();
        if parent != usize::MAX { let p: &mut Node = &mut nodes[parent]; p.children[slot] = me as u32; }
        let mut n = Node::EMPTY;
        let mut ch = plan.children(i);
        ch.sort_by(|a, b| { let f = |s: &Slot| match s { Slot::Node(j) | Slot::Leaf(j) => plan.bounds(*j).half_area() }; f(b).total_cmp(&f(a)) });
        for (s, c) in ch.iter().enumerate() {
            match *c {
                Slot::Leaf(j) => { set(&mut n, s, plan.bounds(j)); n.children[s] = make_block(j, &mut blocks); }
                Slot::Node(j) => { set(&mut n, s, plan.bounds(j)); }
            }
        }
        nodes.push(n);
        for (s, c) in ch.iter().enumerate().rev() { if let Slot::Node(j) = *c { todo.push((j, me, s)); } }
    }
    if env("VERB", 0.0) > 0.0 { eprintln!("emit {:?} nodes {} blocks {} fill {:.2}", t.elapsed(), nodes.len(), blocks.len(), live.len() as f32 / blocks.len() as f32); }
    (nodes, blocks)
}
