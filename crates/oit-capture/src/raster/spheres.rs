//! The CPU rasteriser of spheres.

use oit_fragments::{Fragment, Lfb, depth_key};
use rayon::prelude::*;

use super::{BAND_ROWS, CHUNK, MAX_SIZE_PX, fill};
use crate::spheres::Hit;
use crate::{PlacedSphere, PlacedSpheres};

/// Draws spheres: every fragment, each pixel's in submission order.
///
/// # Panics
/// Where the picture is larger than 65536 pixels in either direction.
#[must_use]
pub fn rasterize_spheres(spheres: &PlacedSpheres) -> Lfb {
    let bands = Bands::new(spheres);
    let counts = bands.count(spheres);
    fill(&spheres.frame, counts, |band, cursors, fragments| {
        bands.each_hit(spheres, band, |pixel, sphere, rgba, hit| {
            let cursor = &mut cursors[pixel];
            fragments[*cursor as usize] = Fragment {
                rgba: spheres.shade(sphere, rgba, hit.at),
                depth_key: depth_key(hit.depth),
            };
            *cursor += 1;
        });
    })
}

/// How many fragments each pixel has, row by row: the counts of [`rasterize_spheres`], without shading.
///
/// # Panics
/// As [`rasterize_spheres`].
#[must_use]
pub fn rasterize_sphere_counts(spheres: &PlacedSpheres) -> Vec<u32> {
    Bands::new(spheres).count(spheres)
}

/// For each chunk of spheres, in the order of submission, and each band of rows, those that touch it.
struct Bands {
    chunks: Vec<Vec<Vec<u32>>>,
}

impl Bands {
    fn new(spheres: &PlacedSpheres) -> Self {
        let frame = &spheres.frame;
        assert!(
            frame.width_px.max(frame.height_px) <= MAX_SIZE_PX,
            "a picture of at most 65536 px"
        );
        let bands = frame.height_px.div_ceil(BAND_ROWS) as usize;
        let chunk = |chunk: u32| {
            let mut lists = vec![Vec::new(); bands];
            let first = chunk * CHUNK as u32;
            for index in first..(first + CHUNK as u32).min(spheres.count()) {
                let [columns, rows] = spheres.pixels(&spheres.sphere(index).0);
                if !columns.is_empty() && !rows.is_empty() {
                    for band in rows.start / BAND_ROWS..=(rows.end - 1) / BAND_ROWS {
                        lists[band as usize].push(index);
                    }
                }
            }
            lists
        };
        let chunks = (0..spheres.count().div_ceil(CHUNK as u32)).into_par_iter().map(chunk);
        Self { chunks: chunks.collect() }
    }

    /// Every hit in a band, with its pixel, counted from the band's first.
    fn each_hit(
        &self,
        spheres: &PlacedSpheres,
        band: usize,
        mut take: impl FnMut(usize, &PlacedSphere, [u8; 4], Hit),
    ) {
        let frame = &spheres.frame;
        let first_row = band as u32 * BAND_ROWS;
        for &index in self.chunks.iter().flat_map(|chunk| &chunk[band]) {
            let (sphere, rgba) = spheres.sphere(index);
            let [columns, rows] = spheres.pixels(&sphere);
            for row in rows.start.max(first_row)..rows.end.min(first_row + BAND_ROWS) {
                for column in columns.clone() {
                    if let Some(hit) = spheres.hit(&sphere, column, row) {
                        let pixel = ((row - first_row) * frame.width_px + column) as usize;
                        take(pixel, &sphere, rgba, hit);
                    }
                }
            }
        }
    }

    fn count(&self, spheres: &PlacedSpheres) -> Vec<u32> {
        let frame = &spheres.frame;
        let mut counts = vec![0; frame.width_px as usize * frame.height_px as usize];
        let band_pixels = frame.width_px as usize * BAND_ROWS as usize;
        counts.par_chunks_mut(band_pixels.max(1)).enumerate().for_each(|(band, counts)| {
            self.each_hit(spheres, band, |pixel, _, _, _| counts[pixel] += 1);
        });
        counts
    }
}
