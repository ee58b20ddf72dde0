//! What kinds of places a photo has, by what its camera's rays hit first.

use gonio_scene::Film;
use std::collections::BTreeMap;

/// What a place can tell of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    /// Nothing is hit.
    Behind,
    /// Objects or surfaces meet: silhouettes, creases; poses and meshes show there.
    Edge,
    /// Within a lamp's highlight: roughness and index of refraction.
    Highlight,
    /// Where a highlight fades: what tells lobes apart.
    Flank,
    /// Seen at a grazing angle: Fresnel reflection.
    Grazing,
    /// All else: colour.
    Plain,
}

/// Half angle in radians up to which a place lies in a highlight, and up to which on its flank. A lobe of roughness 0.4 (GGX
/// alpha 0.16) has fallen to a half at 0.1 rad and to a hundredth at 0.46 rad.
const HALF: [f64; 2] = [0.15, 0.5];

/// Angle to the normal in radians from which on reflection by Fresnel's equations rises: at 63 degrees it has doubled for an index of 1.5.
const GRAZING: f64 = 1.1;

/// Angle in radians between the normals of neighbours from which on an edge lies between them.
const CREASE: f64 = 0.5;

/// A photo's places of one kind on one object; object -1 is none.
pub type Stratum = (i32, Kind);

/// Indices of a first-hit film's channels.
const NORMAL: [usize; 3] = [1, 2, 3];
const OBJECT: usize = 4;
const HALF_ANGLE: usize = 8;
const INCIDENCE: usize = 9;

/// The places of every stratum of a first-hit film, row-major indices in ascending order.
pub fn strata(film: &Film) -> BTreeMap<Stratum, Vec<usize>> {
    let (width, height) = (film.width as usize, film.height as usize);
    let mut strata: BTreeMap<Stratum, Vec<usize>> = BTreeMap::new();
    for place in 0..width * height {
        let (x, y) = (place % width, place / width);
        let right = (x + 1 < width).then_some(place + 1);
        let left = x.checked_sub(1).map(|_| place - 1);
        let below = (y + 1 < height).then_some(place + width);
        let above = y.checked_sub(1).map(|_| place - width);
        let at_edge = [right, left, below, above].into_iter().flatten().any(|other| differs(film, place, other));
        let object = film.channels[OBJECT][place];
        #[allow(clippy::cast_possible_truncation)]
        strata.entry((object as i32, kind(film, place, at_edge))).or_default().push(place);
    }
    strata
}

fn kind(film: &Film, place: usize, at_edge: bool) -> Kind {
    let value = |channel: usize| f64::from(film.channels[channel][place]);
    let half = value(HALF_ANGLE);
    if at_edge {
        Kind::Edge
    } else if value(OBJECT) < 0.0 {
        Kind::Behind
    // Where no lamp is point-like, there is no half angle: it is 0 to the last bit.
    } else if half > 0.0 && half < HALF[0] {
        Kind::Highlight
    } else if half > 0.0 && half < HALF[1] {
        Kind::Flank
    } else if value(INCIDENCE) > GRAZING {
        Kind::Grazing
    } else {
        Kind::Plain
    }
}

/// Whether two places lie on different objects, or on surfaces that meet at an angle.
fn differs(film: &Film, a: usize, b: usize) -> bool {
    let object = |place: usize| film.channels[OBJECT][place];
    let cosine: f64 = NORMAL.iter().map(|c| f64::from(film.channels[*c][a]) * f64::from(film.channels[*c][b])).sum();
    object(a) != object(b) || (object(a) >= 0.0 && cosine < libm::cos(CREASE))
}

#[cfg(test)]
pub mod tests {
    use super::*;

    /// A film of `width` places to the row whose channels are (object, half angle, incidence), normals along z.
    pub fn film(width: u32, places: &[(f32, f32, f32)]) -> Film {
        let mut channels = vec![vec![0.0; places.len()]; 10];
        channels[3] = vec![1.0; places.len()];
        for (i, (object, half, incidence)) in places.iter().enumerate() {
            (channels[4][i], channels[8][i], channels[9][i]) = (*object, *half, *incidence);
        }
        Film { photo: 0, width, height: places.len() as u32 / width, channels }
    }

    #[test]
    fn every_place_is_in_one_stratum() {
        let mut places = vec![(0.0, 0.9, 0.2); 30];
        places[3..5].fill((0.0, 0.1, 0.2));
        places[5] = (0.0, 0.3, 1.4);
        places[6] = (0.0, 0.9, 1.4);
        places[10..20].fill((0.0, 0.0, 0.2));
        places[20..30].fill((-1.0, 0.0, 0.0));
        let found = strata(&film(10, &places));
        assert_eq!(found[&(0, Kind::Highlight)], [3, 4]);
        assert_eq!(found[&(0, Kind::Flank)], [5]);
        assert_eq!(found[&(0, Kind::Grazing)], [6]);
        assert_eq!(found[&(0, Kind::Plain)], [0, 1, 2, 7, 8, 9]);
        // The rows on either side of the silhouette.
        assert_eq!(found[&(0, Kind::Edge)], (10..20).collect::<Vec<_>>());
        assert_eq!(found[&(-1, Kind::Edge)], (20..30).collect::<Vec<_>>());
        assert_eq!(found.values().map(Vec::len).sum::<usize>(), 30);
    }
}
