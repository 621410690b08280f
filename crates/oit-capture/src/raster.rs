//! The CPU rasteriser: the twin of what a device does between the vertex and the fragment shader.
//!
//! Rows are shared out in bands. Triangles are set up once, in chunks, and listed by the bands they
//! touch; then each band counts its fragments, and once all counts are known, each band writes its
//! fragments to where they belong. Nothing depends on the number of threads: a pixel's fragments
//! are always in submission order.

mod clip;
mod spheres;
mod triangle;

use glam::{Vec3, Vec4};
use oit_fragments::{Fragment, Lfb, depth_key};
use oit_scene::{Camera, Mesh, Shading, Vertex};
use rayon::prelude::*;

use crate::Frame;
pub use spheres::{rasterize_sphere_counts, rasterize_spheres};

use clip::{ALL_OUT, NEEDS_CLIP, View};
use triangle::Triangle;

/// Rows of a band. Small bands share out better, large ones repeat less of a triangle's set-up.
const BAND_ROWS: u32 = 8;

/// Triangles of a chunk.
const CHUNK: usize = 8192;

/// The largest width and height; coordinates in 256ths of a pixel are exact up to here.
const MAX_SIZE_PX: u32 = 1 << 16;

/// Draws a mesh: every fragment, each pixel's in submission order.
///
/// Triangles are clipped at the near and the far plane, and never culled. Positions are snapped to
/// 256ths of a pixel, pixels are sampled at their centres, and a centre on an edge belongs to the
/// triangle of which that is a top or left edge, as Vulkan, Direct3D and WebGPU have it. Depth is
/// interpolated linearly on the screen, colour and normals with perspective. A triangle with a
/// corner that is not finite, or is not in the mesh, is left out.
///
/// # Panics
/// Where the picture is larger than 65536 pixels in either direction.
#[must_use]
pub fn rasterize(
    mesh: &Mesh,
    shading: &Shading,
    camera: &Camera,
    width_px: u32,
    height_px: u32,
) -> Lfb {
    let frame = Frame::new(shading, camera, width_px, height_px);
    let chunks = set_up(mesh, &frame);
    let counts = count(&chunks, &frame);
    fill(&frame, counts, |band, cursors, fragments| {
        let first_row = band as u32 * BAND_ROWS;
        for triangle in triangles(&chunks, band) {
            let source = &mesh.indices[3 * triangle.source as usize..][..3];
            let corners = [0, 1, 2].map(|i| &mesh.vertices[source[i] as usize]);
            for row in triangle.rows(first_row, BAND_ROWS) {
                let pixels = &mut cursors[((row - first_row) * width_px) as usize..];
                for x in triangle.span(row) {
                    let cursor = &mut pixels[x as usize];
                    fragments[*cursor as usize] = shade(&frame, triangle, corners, x, row);
                    *cursor += 1;
                }
            }
        }
    })
}

/// Fragments of which it is known how many each pixel has. Of each band `draw` gets the place of the
/// next fragment of each of its pixels, which it moves on, and the band's fragments.
fn fill(
    frame: &Frame,
    mut counts: Vec<u32>,
    draw: impl Fn(usize, &mut [u32], &mut [Fragment]) + Sync,
) -> Lfb {
    let mut offsets = Vec::with_capacity(counts.len() + 1);
    let mut total = 0;
    offsets.push(0);
    offsets.extend(counts.iter().map(|&count| {
        total += count as usize;
        total
    }));
    let mut fragments = vec![Fragment::default(); total];

    let band_pixels = frame.width_px as usize * BAND_ROWS as usize;
    let mut bands = Vec::new();
    let mut rest = fragments.as_mut_slice();
    for (band, counts) in counts.chunks_mut(band_pixels.max(1)).enumerate() {
        let first = band * band_pixels;
        let (own, others) = rest.split_at_mut(offsets[first + counts.len()] - offsets[first]);
        rest = others;
        bands.push((counts, own));
    }
    bands.into_par_iter().enumerate().for_each(|(band, (cursors, fragments))| {
        // The counts have served; from here on they say where a pixel's next fragment goes.
        let mut start = 0;
        for cursor in cursors.iter_mut() {
            start += std::mem::replace(cursor, start);
        }
        draw(band, cursors, fragments);
    });
    Lfb::new(frame.width_px, frame.height_px, offsets, fragments)
        .expect("offsets are sums of counts")
}

/// How many fragments each pixel has, row by row: the counts of [`rasterize`], without shading.
///
/// # Panics
/// As [`rasterize`].
#[must_use]
pub fn rasterize_counts(mesh: &Mesh, camera: &Camera, width_px: u32, height_px: u32) -> Vec<u32> {
    let unlit = Shading { light: [0.0; 3], ambient: 1.0, stripes: None };
    let frame = Frame::new(&unlit, camera, width_px, height_px);
    count(&set_up(mesh, &frame), &frame)
}

/// Some triangles in submission order, set up.
struct Chunk {
    triangles: Vec<Triangle>,
    /// For each band the triangles that touch it.
    bands: Vec<Vec<u32>>,
}

/// The triangles that touch a band, in submission order.
fn triangles(chunks: &[Chunk], band: usize) -> impl Iterator<Item = &Triangle> {
    chunks.iter().flat_map(move |chunk| {
        chunk.bands[band].iter().map(|&index| &chunk.triangles[index as usize])
    })
}

fn set_up(mesh: &Mesh, frame: &Frame) -> Vec<Chunk> {
    assert!(frame.width_px.max(frame.height_px) <= MAX_SIZE_PX, "a picture of at most 65536 px");
    let view = View::new(frame);
    let vertex = |vertex: &Vertex| {
        let clip = frame.project(vertex.position.into());
        (view.corner(clip), view.outcode(clip))
    };
    let corners: Vec<_> = mesh.vertices.par_iter().with_min_len(4096).map(vertex).collect();
    let bands = frame.height_px.div_ceil(BAND_ROWS) as usize;
    let chunk = |(chunk, indices): (usize, &[[u32; 3]])| {
        let mut triangles = Vec::new();
        for (i, &indices) in indices.iter().enumerate() {
            let [Some(a), Some(b), Some(c)] = indices.map(|i| corners.get(i as usize)) else {
                continue;
            };
            let source = (chunk * CHUNK + i) as u32;
            if a.1 & b.1 & c.1 & ALL_OUT != 0 {
                continue;
            }
            if (a.1 | b.1 | c.1) & NEEDS_CLIP == 0 {
                triangles.extend(Triangle::new([a.0, b.0, c.0], frame, source, None));
            } else {
                let clip =
                    indices.map(|i| frame.project(mesh.vertices[i as usize].position.into()));
                view.clip(clip, |corners, weights| {
                    triangles.extend(Triangle::new(corners, frame, source, Some(weights)));
                });
            }
        }
        let mut lists = vec![Vec::new(); bands];
        for (index, triangle) in triangles.iter().enumerate() {
            for band in triangle.top / BAND_ROWS..=triangle.bottom / BAND_ROWS {
                lists[band as usize].push(index as u32);
            }
        }
        Chunk { triangles, bands: lists }
    };
    mesh.indices.as_chunks().0.par_chunks(CHUNK).enumerate().map(chunk).collect()
}

fn count(chunks: &[Chunk], frame: &Frame) -> Vec<u32> {
    let width = frame.width_px as usize;
    let mut counts = vec![0; width * frame.height_px as usize];
    let band_pixels = width * BAND_ROWS as usize;
    counts.par_chunks_mut(band_pixels.max(1)).enumerate().for_each(|(band, counts)| {
        let first_row = band as u32 * BAND_ROWS;
        for triangle in triangles(chunks, band) {
            for row in triangle.rows(first_row, BAND_ROWS) {
                let span = triangle.span(row);
                let row = (row - first_row) as usize * width;
                for count in &mut counts[row + span.start as usize..row + span.end as usize] {
                    *count += 1;
                }
            }
        }
    });
    counts
}

fn shade(frame: &Frame, triangle: &Triangle, corners: [&Vertex; 3], x: u32, y: u32) -> Fragment {
    let (depth, weights) = triangle.interpolate(x, y);
    let vector = |of: fn(&Vertex) -> [f32; 3]| {
        let [a, b, c] = corners.map(|corner| Vec3::from(of(corner)));
        a * weights.x + b * weights.y + c * weights.z
    };
    let [a, b, c] = corners.map(|v| Vec4::from(v.rgba.map(|channel| f32::from(channel) / 255.0)));
    let rgba = a * weights.x + b * weights.y + c * weights.z;
    Fragment {
        rgba: frame.shade(vector(|v| v.position), vector(|v| v.normal), rgba),
        depth_key: depth_key(depth),
    }
}
