//! One photo of the report: photograph, render and residual side by side.

use super::html::{escape, significant};
use super::picture::{Tone, data_uri, dimmed, diverging, legend, png};
use bytes::Bytes;
use gonio_scene::capture::{Role, Sensor};
use gonio_scene::{Capture, Film, PhotoStatistics, Photograph, SensorStage};

/// Longest side of a picture of a page in pixels; larger photos are averaged over blocks. Three pictures of so many pixels take
/// about 0.4 MB of a page.
pub const LONGEST: u32 = 320;

/// A photo with its render, ready to be shown; holds pictures and sums, no values.
#[derive(Debug, Clone)]
pub struct Panel {
    /// The photo's name.
    pub name: String,
    /// Whether it was kept from the fit.
    pub held_out: bool,
    /// Pixels that count.
    pub counted: u64,
    /// Pixels inside the mask that are clipped.
    pub clipped: u64,
    /// Chi-square per observation.
    pub reduced_chi_square: f64,
    /// Root of the mean squared residual, in photo values.
    pub rmse: f64,
    tone: Tone,
    /// Side of the blocks that were averaged into one pixel.
    block: usize,
    width: usize,
    height: usize,
    /// PNGs of photograph, render and residual.
    pngs: [Bytes; 3],
}

/// One pixel of the panel: means over a block.
#[derive(Default, Clone, Copy)]
struct Cell {
    photo: [f64; 3],
    render: [f64; 3],
    residual: f64,
    pixels: f64,
    counted: f64,
}

impl Panel {
    /// A panel of photo `statistics.photo` of `capture`, from its values, its film and its comparison at the same
    /// parameters. `None` where the three do not belong together.
    #[must_use]
    pub fn new(capture: &Capture, photograph: &Photograph, film: &Film, statistics: &PhotoStatistics) -> Option<Self> {
        let photo = capture.photos.get(statistics.photo)?;
        let (width, height) = (photograph.image.width as usize, photograph.image.height as usize);
        let pixels = width * height;
        let fits = (film.width, film.height) == (photograph.image.width, photograph.image.height)
            && film.channels.len() == 3
            && film.channels.iter().all(|channel| channel.len() == pixels)
            && photograph.counts.len() == pixels
            && photograph.image.pixels.len() == pixels;
        if !fits || pixels == 0 {
            return None;
        }
        let counting = || photograph.image.pixels.iter().zip(&photograph.counts).filter(|(_, counts)| **counts);
        let brightest = counting().map(|(pixel, _)| pixel.iter().copied().fold(0.0, f32::max)).collect();
        let tone = Tone::of(brightest, &capture.sensor.response);
        let block = width.max(height).div_ceil(LONGEST as usize);
        let render = SensorStage::of(capture, statistics.photo).photo_values(film);
        let cells = cells(photograph, &render, &capture.sensor, block);
        let (columns, rows) = (width.div_ceil(block), height.div_ceil(block));
        let picture = |colour: &dyn Fn(&Cell) -> [u8; 3]| {
            let pixels: Vec<[u8; 3]> =
                cells.iter().map(|cell| dimmed(colour(cell), 2.0 * cell.counted >= cell.pixels)).collect();
            png(u32::try_from(columns).unwrap_or(0), u32::try_from(rows).unwrap_or(0), &pixels)
        };
        #[allow(clippy::cast_precision_loss)]
        let observations = (statistics.observations as f64).max(1.0);
        Some(Self {
            name: photo.name().to_owned(),
            held_out: photo.role == Role::HeldOut,
            counted: counting().count() as u64,
            clipped: photograph.clipped as u64,
            reduced_chi_square: statistics.reduced_chi_square(),
            rmse: (statistics.squared_error.max(0.0) / observations).sqrt(),
            tone,
            block,
            width: columns,
            height: rows,
            pngs: [
                picture(&|cell| cell.photo.map(|v| tone.show(v))),
                picture(&|cell| cell.render.map(|v| tone.show(v))),
                picture(&|cell| diverging(cell.residual)),
            ],
        })
    }

    /// The same, of a photo each of whose pixels is the mean of `factor` by `factor` of the file's. Its residual is in standard
    /// deviations of one pixel of the file.
    #[must_use]
    pub fn shrunk(self, factor: u32) -> Self {
        let pixels = u64::from(factor) * u64::from(factor);
        Self { counted: self.counted * pixels, block: self.block * factor as usize, ..self }
    }

    /// PNGs of photograph, render and residual, all of one size.
    #[must_use]
    pub fn pngs(&self) -> &[Bytes; 3] {
        &self.pngs
    }

    /// Addresses of the pictures of photograph, render and residual, and their size.
    pub(super) fn pictures(&self) -> ([String; 3], usize, usize) {
        (self.pngs.each_ref().map(|png| data_uri(png)), self.width, self.height)
    }

    fn html(&self) -> String {
        let name = escape(&self.name);
        let exposure = if self.tone.encode {
            format!("shown with the sRGB curve at {:+.1} stops", self.tone.stops).replace('-', "\u{2212}")
        } else {
            "shown as the file has it (sRGB)".to_owned()
        };
        let averaged =
            if self.block > 1 { format!(", averaged over {0}×{0} pixels", self.block) } else { String::new() };
        let captions = ["Photo", "Render", "Residual: (photo \u{2212} render) / \u{3c3}"];
        let alternatives = ["the photograph", "the render at the fitted values", "the residual in standard deviations"];
        let figures: String = self
            .pictures()
            .0
            .iter()
            .zip(captions.iter().zip(alternatives))
            .map(|(picture, (caption, what))| {
                format!(
                    "<figure><img src=\"{picture}\" width=\"{}\" height=\"{}\" alt=\"Photo {name}: {what}\">\
                     <figcaption>{caption}</figcaption></figure>\n",
                    self.width, self.height
                )
            })
            .collect();
        let (class, badge) =
            if self.held_out { (" held-out", " <span class=\"badge\">held out</span>") } else { ("", "") };
        format!(
            "<section class=\"photo{class}\">\n<h3>Photo {name}{badge}</h3>\n\
             <p>Reduced chi-square {}, RMSE {}; {exposure}{averaged}.</p>\n<div class=\"triple\">\n{figures}</div>\n</section>\n",
            significant(self.reduced_chi_square, 4),
            significant(self.rmse, 3)
        )
    }
}

/// All photos of a report.
pub(super) fn section(panels: &[Panel]) -> String {
    if panels.is_empty() {
        return String::new();
    }
    let photos: String = panels.iter().map(Panel::html).collect();
    format!(
        "<section>\n<h2>Photo, render and residual</h2>\n<p>Residuals are the mean of the three channels, in units of that mean's \
         standard deviation by the sensor's noise; the render's own noise shows besides it. Pixels outside of the mask, and clipped ones, are dimmed.</p>\n{}{photos}</section>\n",
        legend()
    )
}

/// Means over blocks of `block` by `block` pixels, row by row; `render` holds photo values.
fn cells(photograph: &Photograph, render: &Film, sensor: &Sensor, block: usize) -> Vec<Cell> {
    let (width, height) = (photograph.image.width as usize, photograph.image.height as usize);
    let columns = width.div_ceil(block);
    let mut cells = vec![Cell::default(); columns * height.div_ceil(block)];
    for (i, (pixel, counts)) in photograph.image.pixels.iter().zip(&photograph.counts).enumerate() {
        let cell = &mut cells[i / width / block * columns + i % width / block];
        let (mut residual, mut variance) = (0.0, 0.0);
        for (c, (value, channel)) in pixel.iter().zip(&render.channels).enumerate() {
            let photo = f64::from(*value);
            let render = f64::from(channel[i]);
            cell.photo[c] += photo;
            cell.render[c] += render;
            residual += photo - render;
            variance += sensor.variance(f64::from(photograph.surroundings[i][c]));
        }
        cell.pixels += 1.0;
        if *counts {
            cell.counted += 1.0;
        }
        // Of a block that counts in part, only that part's residual is shown.
        if *counts || block == 1 {
            cell.residual += residual / variance.max(f64::MIN_POSITIVE).sqrt();
        }
    }
    for cell in &mut cells {
        cell.photo = cell.photo.map(|v| v / cell.pixels);
        cell.render = cell.render.map(|v| v / cell.pixels);
        cell.residual /= if block == 1 { 1.0 } else { cell.counted.max(1.0) };
    }
    cells
}

#[cfg(test)]
mod tests {
    use super::*;
    use gonio_scene::capture::Photo;
    use gonio_scene::image::Image;

    fn capture() -> Capture {
        let photo = Photo { file: "p/a.exr".to_owned(), role: Role::HeldOut, ..Photo::default() };
        let sensor = Sensor { read_noise: 0.1, ..Sensor::default() };
        Capture { photos: vec![photo], sensor, ..Capture::default() }
    }

    fn photograph(width: u32, height: u32, value: f32) -> Photograph {
        let pixels = (width * height) as usize;
        Photograph::new(Image { width, height, pixels: vec![[value; 3]; pixels] }, vec![true; pixels], 0)
    }

    fn film(width: u32, height: u32, value: f32) -> Film {
        Film { photo: 0, width, height, channels: vec![vec![value; (width * height) as usize]; 3] }
    }

    #[test]
    fn residuals_are_in_standard_deviations_and_positive_where_the_photo_is_brighter() {
        let cells = cells(&photograph(4, 2, 0.5), &film(4, 2, 0.4), &capture().sensor, 1);
        // Three channels of 0.1 each over the root of three variances of 0.01.
        for cell in cells {
            assert!((cell.residual - 3.0_f64.sqrt()).abs() < 1e-6, "{}", cell.residual);
        }
    }

    #[test]
    fn large_photos_are_averaged_over_blocks_that_count() {
        let mut photograph = photograph(5, 3, 1.0);
        photograph.counts[1] = false;
        photograph.image.pixels[1] = [9.0; 3];
        let cells = cells(&photograph, &film(5, 3, 1.0), &capture().sensor, 2);
        assert_eq!(cells.len(), 3 * 2);
        assert_eq!((cells[0].photo[0], cells[0].residual, cells[0].counted), (3.0, 0.0, 3.0));
        assert_eq!(cells[5].pixels, 1.0);
    }

    #[test]
    fn refuses_what_does_not_belong_together() {
        let statistics =
            PhotoStatistics { observations: 24, gram: vec![12.0], noise_floor: 24.0, ..PhotoStatistics::default() };
        let panel = |film: &Film| Panel::new(&capture(), &photograph(4, 2, 0.5), film, &statistics);
        assert!(panel(&film(2, 4, 0.5)).is_none());
        let html = panel(&film(4, 2, 0.5)).unwrap().html();
        assert!(html.contains("held out") && html.contains("Reduced chi-square 0.5000"), "{html}");
        assert_eq!(html.matches("src=\"data:image/png;base64,").count(), 3);
    }
}
