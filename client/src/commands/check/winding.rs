//! Whether a mesh's faces agree on which side is outside.

use gonio_scene::mesh::Mesh;
use std::collections::HashMap;

/// What its edges and faces say of a mesh.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Winding {
    /// Edges of two faces that both walk in one direction: one of the two faces is turned over.
    pub torn: usize,
    /// Faces that lie on another one with the same corners, wound the other way.
    pub doubled: usize,
}

impl Winding {
    /// Looks at the faces of `mesh`; corners at the same place are one, whatever their normals.
    pub fn of(mesh: &Mesh) -> Self {
        let mut places: HashMap<[u32; 3], u32> = HashMap::with_capacity(mesh.positions.len());
        let mut place = |index: u32| {
            let next = u32::try_from(places.len()).unwrap_or(u32::MAX);
            // A negative zero is the same place.
            let position = mesh.positions.get(index as usize).copied().unwrap_or_default();
            *places.entry(position.map(|value| (value + 0.0).to_bits())).or_insert(next)
        };
        let faces: Vec<[u32; 3]> = mesh.triangles.iter().map(|triangle| triangle.map(&mut place)).collect();

        // Per face by its corners in order: how often in either sense.
        let mut twins: HashMap<[u32; 3], [usize; 2]> = HashMap::with_capacity(faces.len());
        // Per edge, from the lower to the higher corner: how often along and against.
        let mut edges: HashMap<[u32; 2], [usize; 2]> = HashMap::with_capacity(faces.len() * 3 / 2);
        for &[a, b, c] in &faces {
            let mut sorted = [a, b, c];
            sorted.sort_unstable();
            let even = [[a, b, c], [b, c, a], [c, a, b]].contains(&sorted);
            twins.entry(sorted).or_default()[usize::from(even)] += 1;
            for (from, to) in [(a, b), (b, c), (c, a)].into_iter().filter(|(from, to)| from != to) {
                edges.entry([from.min(to), from.max(to)]).or_default()[usize::from(from < to)] += 1;
            }
        }
        // Only where two faces meet is it clear that they should agree.
        let torn = edges.values().filter(|counts| matches!(counts, [0, 2] | [2, 0])).count();
        let doubled = twins.values().map(|[odd, even]| odd.min(even) * 2).sum();
        Self { torn, doubled }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tetrahedron() -> Mesh {
        let positions = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        Mesh { positions, triangles: vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]], ..Mesh::default() }
    }

    #[test]
    fn a_closed_surface_that_agrees_has_nothing() {
        assert_eq!(Winding::of(&tetrahedron()), Winding::default());
        // Split at every edge, as a file with face normals is.
        let whole = tetrahedron();
        let positions = whole.triangles.iter().flatten().map(|&index| whole.positions[index as usize]).collect();
        let split = Mesh { positions, triangles: (0..4).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect(), ..whole };
        assert_eq!(Winding::of(&split), Winding::default());
    }

    #[test]
    fn a_face_that_is_turned_over_tears_its_three_edges() {
        let mut mesh = tetrahedron();
        mesh.triangles[2].swap(0, 1);
        assert_eq!(Winding::of(&mesh), Winding { torn: 3, doubled: 0 });
    }

    #[test]
    fn faces_wound_both_ways_lie_on_each_other() {
        let mut mesh = tetrahedron();
        let back: Vec<_> = mesh.triangles.iter().map(|&[a, b, c]| [a, c, b]).collect();
        mesh.triangles.extend(back);
        assert_eq!(Winding::of(&mesh), Winding { torn: 0, doubled: 8 });
    }
}
