//! x
use oit_capture::rasterize_counts;
use oit_fragments::DepthHistogram;
use oit_scene::*;
#[derive(Clone, Copy, Debug)]
struct V { eye: [f32;3], target: [f32;3], fov: f32 }
fn cam(v: &V) -> Camera { Camera { eye: v.eye, target: v.target, up: [0.0,1.0,0.0], projection: Projection::Perspective { fov_y_degrees: v.fov, near: 0.1, far: 100.0 } } }
fn r1(x: f32) -> f32 { (x*10.0).round()/10.0 }
fn main() {
    let s = load(std::path::Path::new("scenes/atrium.toml"), &Default::default()).unwrap();
    let only: Option<String> = std::env::args().nth(1);
    let rounds: u32 = std::env::args().nth(2).map_or(100, |n| n.parse().unwrap());
    for (name, total, peak, w, h) in [("lfb", 17.5e6, 36.0, 1920u32, 1080u32), ("rbs-v1", 17e6, 45.0, 1920,1080), ("rbs-v2", 16e6, 27.0, 1920,1080), ("bma", 14.449e6, 46.0, 1680, 1050)] {
        if only.as_deref().is_some_and(|o| o != name && o != "all") { continue; }
        let eval = |v: &V, full: bool| {
            let k = if full {1} else {2};
            let d = DepthHistogram::from_counts(rasterize_counts(&s.mesh, &cam(v), w/k, h/k));
            let n = f64::from((w/k)*(h/k));
            let t = d.total() as f64 / n * f64::from(w*h);
            let p = |a,b| d.pixels_in(a,b) as f64/n;
            let (p0,p14,p58,p916,p1732,p33)=(p(0,0),p(1,4),p(5,8),p(9,16),p(17,32),p(33,999));
            let pk = if full {1.0} else {1.03};
            let score = 4.0*((t/total).ln().abs()-0.02).max(0.0) + 2.0*((f64::from(d.peak())*pk/peak).ln().abs()-0.03).max(0.0)
              + 3.0*(p0-0.02).max(0.0) + 3.0*(0.62-p14-p58).max(0.0) + 3.0*(p58-p14).max(0.0) + 1.0*(p1732-0.12).max(0.0);
            (score, format!("{:.2}M peak {} [{:.1} {:.1} {:.1} {:.1} {:.1} {:.2}]", t/1e6, d.peak(), p0*100.0,p14*100.0,p58*100.0,p916*100.0,p1732*100.0,p33*100.0))
        };
        let mut r = SplitMix64::new(name.len() as u64 * 77 + rounds as u64);
        let mut all: Vec<(f64, V)> = vec![];
        let ok = |v: &V| -> bool {
            let [x,y,z]=v.eye; let (ax,az)=(x.abs(),z.abs());
            if !(1.5..=1.9).contains(&y) && !(6.9..=7.3).contains(&y) { return false; }
            let court = ax<13.6 && az<4.2 && y < 2.0;
            let side = ax<17.0 && (az-7.2).abs()<0.9;
            let end = (ax-16.2).abs()<0.9 && az<8.1;
            let d=[v.target[0]-x, v.target[1]-y, v.target[2]-z];
            let len=(d[0]*d[0]+d[1]*d[1]+d[2]*d[2]).sqrt();
            if len<6.0 || (d[1]/len).abs()>0.45 || !(48.0..=78.0).contains(&v.fov) { return false; }
            match name {
                "lfb" => (court||end) && y<2.0 && d[0].abs()/len > 0.85,
                "rbs-v1" => side && y<2.0,
                "rbs-v2" => y>6.0 && (side||end),
                _ => (court || end) && y<2.0 ,
            }
        };
        let mut tries=0;
        while tries<rounds {
            let v = V { eye: [r.between(-17.0,17.0), [1.7,7.1][r.below(2)], r.between(-8.0,8.0)].map(r1), target: [r.between(-17.0,17.0), r.between(0.0,8.0), r.between(-8.0,8.0)].map(r1), fov: [50.0,60.0,70.0,75.0][r.below(4)] };
            if !ok(&v) { continue; }
            tries+=1;
            all.push((eval(&v,false).0, v));
        }
        all.sort_by(|a,b| a.0.total_cmp(&b.0));
        all.truncate(5);
        let mut fin=vec![];
        for (sc, v) in all {
            let (mut sc, mut v) = (sc, v);
            let mut i=0;
            while i<rounds/4 {
                let k = if i<rounds/8 {1.0} else {0.4};
                let mut u=v;
                for c in [0,2] { u.eye[c]=r1(u.eye[c]+k*r.between(-0.8,0.8)); }
                for c in 0..3 { u.target[c]=r1(u.target[c]+k*r.between(-1.2,1.2)); }
                u.fov=(u.fov+k*r.between(-5.0,5.0)).round();
                if !ok(&u) { if r.unit()<0.01 {i+=1;} continue; }
                i+=1;
                let (s2,_)=eval(&u,false);
                if s2<sc { sc=s2; v=u; }
            }
            let e=eval(&v,true);
            fin.push((e.0, v, e.1));
        }
        fin.sort_by(|a,b| a.0.total_cmp(&b.0));
        for f in fin { println!("{name} {:.3} {:?} {}", f.0, f.1, f.2); }
    }
}
