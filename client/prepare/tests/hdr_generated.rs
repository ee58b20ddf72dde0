//! Stacks with a known response, known radiance and known noise.

#![allow(clippy::unwrap_used)] // a test fails by panicking

use gonio_prepare::hdr::{Mark, Merged, Region, Response, Shot, Stack, align, calibrate, correct_times, merge};
use gonio_scene::image::Image;

const SIZE: [usize; 2] = [240, 160];

/// A number 0..1 that follows from its arguments.
fn hash(a: u64, b: u64) -> f64 {
    let mut x = a.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ b.wrapping_mul(0xc2b2_ae3d_27d4_eb4f);
    x ^= x >> 29;
    x = x.wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x ^= x >> 32;
    (x >> 11) as f64 / (1_u64 << 53) as f64
}

/// Normally distributed, by the sum of twelve.
fn normal(a: u64, b: u64) -> f64 {
    (0..12).map(|k| hash(a * 12 + k, b)).sum::<f64>() - 6.0
}

/// A scene over 13 stops: a ramp with soft waves, differently coloured.
fn radiance(x: f64, y: f64) -> [f64; 3] {
    let stop = x / SIZE[0] as f64 * 13.0 - 6.5 + 0.3 * libm::sin(y * 0.12);
    [0.9, 1.0, 0.7].map(|tint| tint * libm::exp2(stop))
}

/// A camera's curve: a gamma with a shoulder, from exposure to 0..1.
fn curve(exposure: f64) -> f64 {
    libm::pow(1.0 - libm::exp(-0.9 * exposure), 1.0 / 2.0)
}

/// A stack at the given seconds; `noise` in codes; `change` alters the radiance of a pixel in a shot.
fn stack(seconds: &[f64], noise: f64, change: impl Fn(usize, usize, usize, [f64; 3]) -> [f64; 3]) -> Vec<Shot> {
    let [width, height] = SIZE;
    let shot = |(k, &seconds): (usize, &f64)| {
        let mut pixels = Vec::with_capacity(width * height);
        for y in 0..height {
            for x in 0..width {
                let light = change(k, x, y, radiance(x as f64, y as f64));
                let seed = (k * width * height + y * width + x) as u64;
                pixels.push(std::array::from_fn(|c| {
                    let code = 255.0 * 1.02 * curve(light[c] * seconds) + noise * normal(seed, c as u64);
                    (code.round().clamp(0.0, 255.0) / 255.0) as f32
                }));
            }
        }
        Shot {
            name: format!("shot{k}.png"),
            image: Image { width: width as u32, height: height as u32, pixels },
            seconds,
        }
    };
    seconds.iter().enumerate().map(shot).collect()
}

fn times(count: i32) -> Vec<f64> {
    (0..count).map(|k| libm::exp2(f64::from(6 - k))).collect()
}

/// Largest error of column means and median error of pixels over twelve stops, of any channel, after one scale for all.
fn errors(merged: &Merged, use_it: impl Fn(usize, usize) -> bool) -> (f64, f64) {
    let [width, height] = SIZE;
    let first = (0.5 / 13.0 * width as f64) as usize;
    let mut scale = None;
    let (mut worst, mut middle) = (0.0_f64, 0.0_f64);
    for c in [1, 0, 2] {
        let mut ratios = Vec::new();
        let mut columns = Vec::new();
        for x in first..width - first {
            let ratio =
                |y: usize| f64::from(merged.radiance.pixels[y * width + x][c]) / radiance(x as f64, y as f64)[c];
            let column: Vec<f64> = (0..height).filter(|&y| use_it(x, y)).map(ratio).collect();
            if !column.is_empty() {
                columns.push(column.iter().sum::<f64>() / column.len() as f64);
            }
            ratios.extend(column);
        }
        ratios.sort_by(f64::total_cmp);
        let scale = *scale.get_or_insert(ratios[ratios.len() / 2]);
        let mut off: Vec<f64> = ratios.iter().map(|ratio| (ratio / scale - 1.0).abs()).collect();
        off.sort_by(f64::total_cmp);
        let column = columns.iter().map(|mean| (mean / scale - 1.0).abs()).fold(0.0, f64::max);
        let (median, most) = (off[off.len() / 2], off[off.len() * 95 / 100]);
        println!("channel {c}: worst column {column:.4}, median pixel {median:.4}, 95 % {most:.4}");
        worst = worst.max(column);
        middle = middle.max(median);
    }
    (worst, middle)
}

fn hold(merged: &Merged) {
    let (worst, median) = errors(merged, |_, _| true);
    assert!(worst < 0.01 && median < 0.01, "{worst} {median}");
}

#[test]
fn radiance_is_within_one_per_cent_over_twelve_stops() {
    let mut stack = Stack::new(stack(&times(13), 0.8, |_, _, _, light| light), None).unwrap();
    assert_eq!(correct_times(&mut stack, Region::All, None), []);
    let response = calibrate(&stack, Region::All).unwrap();
    let merged = merge(&stack, &response);
    hold(&merged);
    let read = Response::from_json("r.json", &response.to_json()).unwrap();
    assert_eq!(merge(&stack, &read).radiance, merged.radiance);
}

/// ln of the exposure that gives a code.
fn truth(code: usize) -> f64 {
    let value = code as f64 / 255.0 / 1.02;
    libm::log(-libm::log(1.0 - value * value) / 0.9)
}

/// Exposures a whole stop apart say nothing of a wave of that period on the curve: only its smoothness does.
#[test]
fn the_response_is_within_one_per_cent_over_its_codes() {
    for noise in [0.0, 0.8] {
        let stack = Stack::new(stack(&times(13), noise, |_, _, _, light| light), None).unwrap();
        let response = calibrate(&stack, Region::All).unwrap();
        for table in &response.log_exposure {
            let off: Vec<f64> = (10..=245).map(|code| table[code] - truth(code)).collect();
            let mean = off.iter().sum::<f64>() / off.len() as f64;
            let worst = off.iter().map(|off| (off - mean).abs()).fold(0.0, f64::max);
            println!("noise {noise}: the curve is at most {worst:.4} off");
            assert!(worst < 0.01, "{worst}");
        }
    }
}

/// Two exposures show some codes once only, and others never: there the curve goes on as the plain one does.
#[test]
fn two_exposures_of_a_dim_scene_give_a_curve_that_goes_on() {
    let dim = |_: usize, x: usize, _: usize, _: [f64; 3]| [0.02 + 0.2 * x as f64 / SIZE[0] as f64; 3];
    let stack = Stack::new(stack(&[1.0, 0.5], 0.8, dim), None).unwrap();
    let response = calibrate(&stack, Region::All).unwrap();
    let table = &response.log_exposure[1];
    let off = |code: usize| table[code] - table[80] - truth(code) + truth(80);
    let worst = (20..=110).map(|code| off(code).abs()).fold(0.0, f64::max);
    println!("at most {worst:.4} off within the scene's codes, {:.4} at code 160", off(160));
    assert!(worst < 0.02 && off(160).abs() < 0.1, "{worst} {}", off(160));
}

#[test]
fn a_moving_highlight_is_left_out() {
    // A lamp's reflection wanders: 3 stops brighter, on other pixels in every shot.
    let inside = |k: usize, x: usize, y: usize| x.abs_diff(20 + 16 * k) < 9 && y.abs_diff(80) < 20;
    let moving = |k: usize, x: usize, y: usize, light: [f64; 3]| {
        if inside(k, x, y) { light.map(|light| 8.0 * light) } else { light }
    };
    let mut stack = Stack::new(stack(&times(13), 0.8, moving), None).unwrap();
    assert_eq!(correct_times(&mut stack, Region::All, None), []);
    let merged = merge(&stack, &calibrate(&stack, Region::All).unwrap());
    hold(&merged);
    assert!(merged.marks.iter().filter(|&&mark| mark == Mark::Moved).count() > 500);
}

#[test]
fn a_wrong_time_is_named_and_mended() {
    for wrong in [0, 4, 9] {
        let mut shots = stack(&times(13), 0.8, |_, _, _, light| light);
        let truth = shots[wrong].seconds;
        shots[wrong].seconds *= 1.6;
        let mut stack = Stack::new(shots, None).unwrap();
        let suspects = correct_times(&mut stack, Region::All, None);
        println!("{suspects:?}");
        assert_eq!(suspects.len(), 1);
        assert_eq!(suspects[0].name, format!("shot{wrong}.png"));
        assert!((suspects[0].found / truth - 1.0).abs() < 0.02, "{suspects:?}");
        hold(&merge(&stack, &calibrate(&stack, Region::All).unwrap()));
    }
}

#[test]
fn two_saturated_frames_add_nothing() {
    let mut all = vec![40_000.0, 20_000.0];
    all.extend(times(13));
    let stack = Stack::new(stack(&all, 0.8, |_, _, _, light| light), None).unwrap();
    let merged = merge(&stack, &calibrate(&stack, Region::All).unwrap());
    let expected: Vec<_> = ["shot0.png", "shot1.png"].map(|name| (name.to_owned(), Mark::Saturated)).into();
    assert_eq!(merged.useless, expected);
    hold(&merged);
}

#[test]
fn a_hand_held_stack_is_aligned() {
    let pattern = |x: f64, y: f64| {
        let light = libm::exp2(3.0 * libm::sin(x * 0.09 + y * 0.03) + 2.0 * libm::cos(y * 0.11 - x * 0.02));
        [light; 3]
    };
    let moved: [[i32; 2]; 5] = [[0, 0], [7, -3], [-12, 5], [3, 20], [0, 0]];
    let change = |k: usize, x: usize, y: usize, _: [f64; 3]| {
        pattern(x as f64 + f64::from(moved[k][0]), y as f64 + f64::from(moved[k][1]))
    };
    let mut stack = Stack::new(stack(&[4.0, 2.0, 1.0, 0.5, 0.25], 0.8, change), None).unwrap();
    let shifts = align::shifts(&stack);
    for (shift, to) in shifts.iter().zip(moved) {
        for axis in 0..2 {
            assert!((shift[axis] - (to[axis] - moved[2][axis])).abs() <= 1, "{shifts:?}");
        }
    }
    stack.shift(&shifts);
    assert!(stack.value(0, 0).is_none() || shifts[0] == [0, 0]);
}

#[test]
fn bad_stacks_are_refused_by_name() {
    let shot = |name: &str, seconds: f64, width: u32| Shot {
        name: name.to_owned(),
        image: Image { width, height: 16, pixels: vec![[0.5; 3]; width as usize * 16] },
        seconds,
    };
    let refusal = |shots: Vec<Shot>| Stack::new(shots, None).unwrap_err().to_string();
    assert!(refusal(vec![shot("a.jpg", 1.0, 16)]).contains("a.jpg"));
    assert!(refusal(vec![]).contains("two or more"));
    assert!(refusal(vec![shot("a.jpg", 1.0, 16), shot("b.jpg", 1.0, 16)]).contains("seconds"));
    assert!(refusal(vec![shot("a.jpg", 1.0, 16), shot("b.jpg", 2.0, 20)]).contains("b.jpg"));
    assert!(refusal(vec![shot("a.jpg", 1.0, 16), shot("b.jpg", -2.0, 16)]).contains("b.jpg"));
    // All alike: there is nothing to learn from at the ends of the curve, but an answer.
    let flat = Stack::new(vec![shot("a.jpg", 1.0, 16), shot("b.jpg", 2.0, 16)], None).unwrap();
    let _ = calibrate(&flat, Region::All).map(|response| merge(&flat, &response));
}
