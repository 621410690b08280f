mod molecule;
mod place;

use glam::{Quat, Vec3};

use self::molecule::{Ball, Shape};
use self::place::{Cone, Part, Place, any_rotation, on_sphere, scattered, unit, upright};
use super::{GenerateError, SphereGenerator};
use crate::detail::Cloud;
use crate::mesh::to_byte;
use crate::{MAX_OBJECTS, Object, Parameter, Params, Spheres, SplitMix64};

/// An HIV-like virus in blood plasma, cut open: the real-world scene of Kugler 2018 (chapter 3, Figure
/// 3.2), whose data are not published. World units are nanometres.
///
/// A sphere of membrane bears spikes and proteins of the host, and is lined with matrix proteins;
/// within are enzymes and a cone of capsid proteins with two strands of RNA. Around it is plasma.
/// Sizes are a virus's: 132 nm across, 1,600 matrix trimers, 250 capsomers, 12 of them pentamers, seven
/// at the wide end; but of spikes there are more than most have. Proteins are grown from balls at random
/// to their volume by mass, and have none of a real one's folds.
pub(super) struct Virus;

const PARAMETERS: &[Parameter] = &[
    Parameter::integer("objects", "Molecules of one virus and its plasma.", 35_000, 1, 1 << 20),
    Parameter::integer(
        "factor",
        "How many times as many: so many viruses with their plasma side by side and behind one another.",
        1,
        1,
        1 << 20,
    ),
    Parameter::integer("kinds", "Types of molecules.", 100, FIXED_KINDS + 1, 1000),
    Parameter::integer("levels", "Levels of detail of a type, at most.", 5, 1, 8),
    Parameter::number(
        "pixels",
        "How wide a coarser level's spheres appear where it begins, in a picture of 1080 lines that sees 40 degrees from top to bottom.",
        7.9,
        0.1,
        1e3,
    ),
    Parameter::number(
        "grain",
        "Distance between neighbouring spheres of a protein at full detail, nm; atoms are 0.26 apart.",
        0.4,
        0.25,
        10.0,
    ),
    Parameter::number(
        "cutaway",
        "What is cut off towards +z, as a share of the virus's diameter; the genome and the capsid's narrow end stay.",
        0.5,
        0.0,
        1.0,
    ),
    Parameter::number(
        "membrane_alpha",
        "Opacity of the membrane and the host's proteins in it.",
        1.0,
        0.0,
        1.0,
    ),
    Parameter::number("spike_alpha", "Opacity of the spikes.", 1.0, 0.0, 1.0),
    Parameter::number("matrix_alpha", "Opacity of the matrix.", 1.0, 0.0, 1.0),
    Parameter::number("capsid_alpha", "Opacity of the capsid.", 1.0, 0.0, 1.0),
    Parameter::number("genome_alpha", "Opacity of the genome.", 1.0, 0.0, 1.0),
    Parameter::number("enzyme_alpha", "Opacity of what else is within the virus.", 1.0, 0.0, 1.0),
    Parameter::number("plasma_alpha", "Opacity of the plasma's proteins.", 1.0, 0.0, 1.0),
    Parameter::integer("seed", "Seed of the random numbers.", 1, 0, i64::MAX as u64),
];

/// Middle of the membrane.
const RADIUS: f32 = 66.0;
/// Of the middles of matrix trimers.
const MATRIX_RADIUS: f32 = 60.0;
/// What lies within the matrix.
const INNER_RADIUS: f32 = 55.0;
/// Plasma is kept out of this.
const OUTER_RADIUS: f32 = 74.0;
/// Of the box of plasma, and from one virus to the next.
const BOX: Vec3 = Vec3::new(400.0, 230.0, 165.0);
/// How far the box may reach in front of the middle, where nothing is cut.
const FRONT: f32 = 82.0;

/// Its two balls lie within the matrix.
const CAPSID: Cone = Cone {
    // Rising to the right, 30 degrees.
    axis: Vec3::new(0.866_025_4, 0.5, 0.0),
    middles: [-35.0, 16.0],
    radii: [12.0, 26.0],
};
/// Where on the axis the capsid is opened.
const OPENED_FROM: f32 = -14.0;
/// The genome stays so far below the capsid's surface.
const GENOME_MARGIN: f32 = 4.5;
/// Length of the piece of RNA that is one object.
const STRAND: f32 = 1.9;

/// Molecules of a whole virus among [`STANDARD`] with its plasma; what is cut away becomes plasma.
const STANDARD: f64 = 35_000.0;
const LIPIDS: f64 = 15_000.0;
const ANCHORED: f64 = 420.0;
const SPIKES: f64 = 72.0;
const TRIMERS: f64 = 1600.0;
const CAPSOMERS: f64 = 250.0;
const STRANDS: f64 = 6000.0;
const ENZYMES: f64 = 1500.0;

/// Pentamers at the narrow and the wide end: twelve close any lattice of hexamers.
const PENTAMERS: [usize; 2] = [5, 7];

const LIPID_KINDS: u32 = 8;
const STRAND_KINDS: u32 = 8;
/// Proteins of the host in the membrane, kDa.
const HOSTS: [(&str, f32); 5] =
    [("HLA-A", 44.0), ("HLA-DR", 60.0), ("ICAM-1", 58.0), ("CD55", 41.0), ("CD59", 14.0)];
/// What else is within the virus, kDa.
const INSIDE: [(&str, f32); 11] = [
    ("reverse transcriptase", 117.0),
    ("integrase", 128.0),
    ("protease", 22.0),
    ("nucleocapsid", 7.0),
    ("Vpr", 11.0),
    ("Vif", 23.0),
    ("Nef", 27.0),
    ("p6", 6.0),
    ("cyclophilin A", 18.0),
    ("tRNA-Lys3", 25.0),
    ("actin", 42.0),
];
/// Proteins of blood plasma that are named, kDa; the most abundant first.
const PLASMA: [(&str, f32, Shape); 10] = [
    ("albumin", 66.0, Shape::Globule(5)),
    ("immunoglobulin G", 150.0, Shape::Fork),
    ("transferrin", 80.0, Shape::Globule(4)),
    ("fibrinogen", 340.0, Shape::Rod),
    ("alpha-1 antitrypsin", 52.0, Shape::Globule(3)),
    ("haptoglobin", 100.0, Shape::Globule(7)),
    ("apolipoprotein A-I", 28.0, Shape::Globule(2)),
    ("complement C3", 185.0, Shape::Globule(9)),
    ("alpha-2 macroglobulin", 720.0, Shape::Globule(12)),
    ("haemopexin", 60.0, Shape::Globule(4)),
];
/// Two spikes, two matrix trimers, a hexamer and a pentamer, and those above but for the plasma.
const FIXED_KINDS: u64 =
    6 + (LIPID_KINDS + STRAND_KINDS) as u64 + HOSTS.len() as u64 + INSIDE.len() as u64;

/// Linear values.
const LIPID_HEADS: [u8; 3] = [150, 110, 60];
const LIPID_TAILS: [u8; 3] = [205, 180, 125];
const HOST: [u8; 3] = [60, 120, 70];
const SPIKE: [u8; 3] = [200, 60, 50];
const MATRIX: [u8; 3] = [50, 110, 190];
const CAPSOMER: [u8; 3] = [225, 120, 20];
const RNA: [u8; 3] = [235, 215, 40];
const ENZYME: [u8; 3] = [150, 60, 170];
/// Plasma is between these.
const PLASMA_COLORS: [[u8; 3]; 2] = [[175, 95, 75], [225, 165, 120]];

impl SphereGenerator for Virus {
    fn name(&self) -> &'static str {
        "virus"
    }

    fn parameters(&self) -> &'static [Parameter] {
        PARAMETERS
    }

    fn generate(&self, params: &Params) -> Result<Spheres, GenerateError> {
        let (objects, factor) = (params.integer("objects"), params.integer("factor"));
        let all = objects.saturating_mul(factor);
        if all > MAX_OBJECTS {
            return Err(GenerateError::TooManyObjects { objects: all });
        }
        let mut random = SplitMix64::new(params.integer("seed"));
        let mut spheres = Spheres::default();
        let kinds = Kinds::new(&mut spheres, params, &mut random);
        spheres.objects.reserve_exact(all as usize);
        // One after the other draws its seed, so that a smaller factor's viruses are a larger one's first.
        for offset in nearest_cells(factor) {
            let mut random = SplitMix64::new(random.next_u64());
            let mut placing =
                Placing { objects: &mut spheres.objects, kinds: &kinds, offset: offset * BOX };
            placing.virus(objects, params.number("cutaway"), &mut random);
        }
        Ok(spheres)
    }
}

/// Cells of a lattice by their distance from the first, none of them in front of it.
fn nearest_cells(count: u64) -> Vec<Vec3> {
    // A half ball of this radius has more cells than that.
    let reach = (count as f32).cbrt().ceil() as i32;
    let mut cells: Vec<[i32; 3]> = (-reach..=reach)
        .flat_map(|x| (-reach..=reach).flat_map(move |y| (-reach..=0).map(move |z| [x, y, z])))
        .collect();
    cells.sort_by_key(|cell| (cell.iter().map(|c| c * c).sum::<i32>(), *cell));
    cells.truncate(count as usize);
    cells.into_iter().map(|cell| Vec3::from(cell.map(|c| c as f32))).collect()
}

/// The kinds of one component, as numbers in [`Spheres::kinds`], and the colour of its objects.
#[derive(Debug, Clone)]
struct Component {
    kinds: Vec<u32>,
    rgba: [u8; 4],
}

impl Component {
    fn any(&self, random: &mut SplitMix64) -> u32 {
        self.kinds[random.below(self.kinds.len())]
    }

    /// The first most often: the chance falls as 1 / (place + 3).
    fn by_abundance(&self, random: &mut SplitMix64) -> u32 {
        let (first, last) = (3.0f32, self.kinds.len() as f32 + 3.0);
        let place = first * (last / first).powf(random.unit()) - first;
        self.kinds[(place as usize).min(self.kinds.len() - 1)]
    }
}

/// What objects can be.
struct Kinds {
    lipids: Component,
    hosts: Component,
    spikes: Component,
    matrix: Component,
    /// The hexamer, then the pentamer.
    capsid: Component,
    genome: Component,
    enzymes: Component,
    plasma: Component,
}

impl Kinds {
    fn new(spheres: &mut Spheres, params: &Params, random: &mut SplitMix64) -> Self {
        let (levels, pixels) = (params.integer("levels"), f64::from(params.number("pixels")));
        let grain = params.number("grain");
        let mut add = |name: String, cloud: Cloud| spheres.push_kind(name, cloud, levels, pixels);
        let component = |kinds: Vec<u32>, alpha: &str| {
            let rgba = [255, 255, 255, to_byte(params.number(alpha))];
            Component { kinds, rgba }
        };
        let filled = |balls: &[Ball], rgb: [u8; 3], random: &mut SplitMix64| {
            molecule::fill(balls, grain, rgb, random)
        };

        let lipids = (0..LIPID_KINDS).map(|i| {
            let patch = molecule::lipids(6, LIPID_HEADS, LIPID_TAILS, random);
            add(format!("lipids {}", i + 1), patch)
        });
        let lipids = component(lipids.collect(), "membrane_alpha");
        let hosts = HOSTS.map(|(name, kda)| {
            let balls = molecule::anchored(kda, random);
            add(name.to_owned(), filled(&balls, HOST, random))
        });
        let hosts = component(hosts.to_vec(), "membrane_alpha");
        let spikes = [("spike, closed", false), ("spike, open", true)].map(|(name, open)| {
            add(name.to_owned(), filled(&molecule::spike(open), SPIKE, random))
        });
        let spikes = component(spikes.to_vec(), "spike_alpha");
        let matrix = [0.4, -0.5].map(|twist| {
            let name = format!("matrix {}", if twist > 0.0 { 1 } else { 2 });
            add(name, filled(&molecule::matrix(twist), MATRIX, random))
        });
        let matrix = component(matrix.to_vec(), "matrix_alpha");
        let capsid = [("capsid hexamer", 6), ("capsid pentamer", 5)].map(|(name, proteins)| {
            let balls = molecule::capsomer(proteins, 0.3);
            add(name.to_owned(), filled(&balls, CAPSOMER, random))
        });
        let capsid = component(capsid.to_vec(), "capsid_alpha");
        let genome = (0..STRAND_KINDS).map(|i| {
            let strand = molecule::strand(STRAND, RNA, random);
            add(format!("RNA {}", i + 1), strand)
        });
        let genome = component(genome.collect(), "genome_alpha");
        let enzymes = INSIDE.map(|(name, kda)| {
            let balls = Shape::Globule(2 + (kda / 25.0) as u32).balls(kda, random);
            add(name.to_owned(), filled(&balls, ENZYME, random))
        });
        let enzymes = component(enzymes.to_vec(), "enzyme_alpha");
        let plasma = (0..params.integer("kinds") - FIXED_KINDS).map(|i| {
            let (name, kda, shape) = match PLASMA.get(i as usize) {
                Some((name, kda, shape)) => ((*name).to_owned(), *kda, *shape),
                // From 15 to 250 kDa, small ones more often.
                None => {
                    let kda = 15.0 * (250.0f32 / 15.0).powf(random.unit());
                    let shape = Shape::Globule(1 + random.below(6) as u32);
                    (format!("plasma protein {}", i + 1), kda, shape)
                }
            };
            let balls = shape.balls(kda, random);
            let [from, to] = PLASMA_COLORS;
            let t = random.unit();
            let rgb = std::array::from_fn(|k| {
                (f32::from(from[k]) * (1.0 - t) + f32::from(to[k]) * t).round() as u8
            });
            add(name, filled(&balls, rgb, random))
        });
        let plasma = component(plasma.collect(), "plasma_alpha");
        Self { lipids, hosts, spikes, matrix, capsid, genome, enzymes, plasma }
    }
}

/// One virus while it is put together.
struct Placing<'a> {
    objects: &'a mut Vec<Object>,
    kinds: &'a Kinds,
    /// Of its middle.
    offset: Vec3,
}

impl Placing<'_> {
    fn put(&mut self, component: &Component, kind: u32, at: Vec3, rotation: Quat) {
        self.objects.push(Object {
            position: (self.offset + at).to_array(),
            rotation: rotation.to_array(),
            kind,
            rgba: component.rgba,
        });
    }

    /// Molecules that stand on a sphere.
    fn cover(
        &mut self,
        component: &Component,
        count: u64,
        radius: f32,
        cut: f32,
        random: &mut SplitMix64,
    ) {
        for Place { position, normal } in on_sphere(count, radius) {
            if position.z <= cut {
                let rotation = upright(normal, random);
                self.put(component, component.any(random), position, rotation);
            }
        }
    }

    fn virus(&mut self, objects: u64, cutaway: f32, random: &mut SplitMix64) {
        let before = self.objects.len();
        let kinds = self.kinds;
        // The plane that everything in front of is cut off at.
        let cut = (1.0 - 2.0 * cutaway) * OUTER_RADIUS;
        // Rounded down: all together are never more than there should be.
        let share = |count: f64| (count * objects as f64 / STANDARD) as u64;

        self.cover(&kinds.lipids, share(LIPIDS), RADIUS, cut, random);
        self.cover(&kinds.hosts, share(ANCHORED), RADIUS, cut, random);
        self.cover(&kinds.spikes, share(SPIKES), RADIUS, cut, random);
        self.cover(&kinds.matrix, share(TRIMERS), MATRIX_RADIUS, cut, random);
        self.capsid(share(CAPSOMERS), cut, random);
        let strands = share(STRANDS);
        for count in [strands / 2, strands - strands / 2] {
            for (at, along) in CAPSID.curve(count, STRAND, GENOME_MARGIN, random) {
                let rotation = Quat::from_rotation_arc(Vec3::X, along);
                self.put(&kinds.genome, kinds.genome.any(random), at, rotation);
            }
        }
        for _ in 0..share(ENZYMES) {
            let at = inside(random);
            if at.z <= cut {
                let rotation = any_rotation(random);
                self.put(&kinds.enzymes, kinds.enzymes.any(random), at, rotation);
            }
        }
        let left = objects as usize - (self.objects.len() - before);
        self.plasma(left, cut, random);
    }

    fn capsid(&mut self, count: u64, cut: f32, random: &mut SplitMix64) {
        let component = &self.kinds.capsid;
        let surface = CAPSID.surface(count);
        let mut pentamers = Vec::new();
        for (end, wanted) in [Part::NarrowEnd, Part::WideEnd].into_iter().zip(PENTAMERS) {
            let on_end: Vec<usize> = (0..surface.len()).filter(|i| surface[*i].1 == end).collect();
            pentamers.extend((0..wanted).filter_map(|i| on_end.get(i * on_end.len() / wanted)));
        }
        for (i, (Place { position, normal }, _)) in surface.iter().enumerate() {
            if position.z <= cut || position.dot(CAPSID.axis) < OPENED_FROM {
                let kind = component.kinds[usize::from(pentamers.contains(&i))];
                self.put(component, kind, *position, upright(*normal, random));
            }
        }
    }

    fn plasma(&mut self, count: usize, cut: f32, random: &mut SplitMix64) {
        let component = &self.kinds.plasma;
        let top = cut.min(FRONT);
        let half = BOX / 2.0;
        let low = Vec3::new(-half.x, -half.y, top - BOX.z);
        let high = Vec3::new(half.x, half.y, top);
        // Of the virus what lies behind the plane: a ball's cap, cut at its height.
        let height = (cut + OUTER_RADIUS).clamp(0.0, 2.0 * OUTER_RADIUS);
        let cap = std::f32::consts::PI * height * height * (OUTER_RADIUS - height / 3.0);
        let free = |at: Vec3| at.length() > OUTER_RADIUS;
        let volume = BOX.element_product() - cap;
        for at in scattered(count, [low, high], volume, free, random) {
            let kind = component.by_abundance(random);
            self.put(component, kind, at, any_rotation(random));
        }
    }
}

/// A place within the matrix, not in the capsid's wall.
fn inside(random: &mut SplitMix64) -> Vec3 {
    const WALL: std::ops::Range<f32> = -4.0..5.0;
    loop {
        let at = INNER_RADIUS * random.unit().cbrt() * unit(random);
        if !WALL.contains(&CAPSID.depth(at)) {
            return at;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_begin_at_home_and_are_nested() {
        let most = nearest_cells(500);
        assert_eq!(most.len(), 500);
        assert_eq!(most[0], Vec3::ZERO);
        assert!(most.iter().all(|cell| cell.z <= 0.0));
        for count in [1, 2, 7, 36, 499] {
            assert_eq!(nearest_cells(count), most[..count as usize]);
        }
    }

    #[test]
    fn the_capsid_fits_into_the_matrix() {
        for (Place { position, .. }, _) in CAPSID.surface(2000) {
            assert!(position.length() < INNER_RADIUS, "{position}");
        }
        assert!((CAPSID.axis.length() - 1.0).abs() < 1e-6);
    }
}
