use oit_capture::rasterize_counts;
use oit_fragments::DepthHistogram;
use oit_scene::*;
fn main() {
    let s = load(std::path::Path::new("scenes/atrium.toml"), &Default::default()).unwrap();
    println!("triangles {}", s.mesh.triangle_count());
    for v in &s.views {
        let t = std::time::Instant::now();
        let (w,h) = if v.name=="bma" {(1680,1050)} else {(1920,1080)};
        let d = DepthHistogram::from_counts(rasterize_counts(&s.mesh, &v.camera, w, h));
        let n=(w*h) as f64;
        let i=[(0,0),(1,8),(9,16),(17,32),(33,64),(65,999)].map(|(a,b)| (1000.0*d.pixels_in(a,b) as f64/n).round()/10.0);
        println!("{} total {:.2}M peak {} intervals {:?} {:?}", v.name, d.total() as f64/1e6, d.peak(), i, t.elapsed());
        println!("{:?}", &d.pixels);
    }
}
