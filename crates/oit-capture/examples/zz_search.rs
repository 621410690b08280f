//! x
use oit_capture::rasterize_counts;
use oit_fragments::DepthHistogram;
use oit_scene::*;
fn main() {
    let s = load(std::path::Path::new("scenes/atrium.toml"), &Default::default()).unwrap();
    println!("triangles {}", s.mesh.triangle_count());
    let show = |name: &str, c: &Camera, w: u32, h: u32, hist: bool| {
        let d = DepthHistogram::from_counts(rasterize_counts(&s.mesh, c, w, h));
        let n=(w*h) as f64;
        let full = d.total() as f64/n*1920.0*1080.0/1e6;
        let i=[(0,0),(1,4),(5,8),(9,16),(17,32),(33,64),(65,999)].map(|(a,b)| (1000.0*d.pixels_in(a,b) as f64/n).round()/10.0);
        println!("{name} total {:.2}M full {full:.2} peak {} {:?}", d.total() as f64/1e6, d.peak(), i);
        if hist { println!("{:?}", &d.pixels); }
    };
    for v in &s.views {
        let (w,h) = if v.name=="bma" {(1680,1050)} else {(1920,1080)};
        show(&v.name, &v.camera, w, h, std::env::args().nth(1).is_none());
    }
    let n: u32 = std::env::args().nth(1).map_or(0, |n| n.parse().unwrap());
    let mut r = SplitMix64::new(9);
    for i in 0..n {
        let (x, z) = match i % 3 { 0 => (r.between(-14.0, 14.0), r.between(-5.0, 5.0)), 1 => (r.between(-17.0,17.0), 7.2), _ => (-16.0, r.between(-7.0, 7.0)) };
        let y = if r.unit() < 0.5 || i % 3 == 0 { 1.7 } else { 7.1 };
        let eye = [x, y, z].map(|c: f32| (c*10.0).round()/10.0);
        let target = [r.between(-16.0,16.0), r.between(0.0, 9.0), r.between(-7.0, 7.0)].map(|c: f32| (c*10.0).round()/10.0);
        let fov = [45.0, 60.0, 75.0][r.below(3)];
        let c = Camera { eye, target, up: [0.0,1.0,0.0], projection: Projection::Perspective { fov_y_degrees: fov, near: 0.1, far: 100.0 } };
        show(&format!("{eye:?} {target:?} {fov}"), &c, 960, 540, false);
    }
}
