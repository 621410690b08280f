//! Every CUDA kernel against its CPU twin, with every layout that CUDA reads: compiled as C++ and run
//! a thread after the other, where there is a C++ compiler, and on the GPU, where there is CUDA.

mod support;

use std::fmt::Write as _;
use std::path::Path;
use std::process::Command;

use oit_capture::{CAPTURES, Capture};
use oit_cuda::{Cuda, CudaError, DeviceBuffer};
use oit_fragments::{Fragment, Lfb, Ties};
use oit_gpu::{Buffer, Contents};
use oit_sort::{
    CUDA_KERNEL, CUDA_THREADS, CudaLayout, CudaProgram, End, Output, STRATEGIES, Scratch, SortSpec,
    SortStrategy, patterns, resolve, sorted,
};

/// Pixels of every pattern and of counts about every edge that a kernel has.
fn pixels() -> Lfb {
    let counts = [0, 1, 2, 3, 5, 8, 9, 20, 31, 32, 33, 63, 64, 65, 95, 96, 97, 128, 160, 170];
    let lists = counts.iter().flat_map(|&n| {
        patterns::PATTERNS.iter().map(move |pattern| pattern.fragments(n, n as u64))
    });
    let lists: Vec<Vec<Fragment>> = lists.collect();
    Lfb::from_lists(lists.len() as u32, 1, &lists)
}

/// The captures whose layouts CUDA reads, one for each text.
fn layouts() -> Vec<&'static dyn Capture> {
    let mut seen = Vec::new();
    let mut captures = CAPTURES.to_vec();
    captures.retain(|capture| match capture.layout_cuda() {
        Some(text) if !seen.contains(&text) => {
            seen.push(text);
            true
        }
        _ => false,
    });
    captures
}

fn layout(capture: &'static dyn Capture) -> CudaLayout<'static> {
    CudaLayout {
        name: capture.name(),
        source: capture.layout_cuda().expect("one of `layouts`"),
        random_access: capture.random_access(),
    }
}

/// What is compiled and run: one strategy with one layout.
#[derive(Clone, Copy)]
struct Case {
    strategy: &'static dyn SortStrategy,
    spec: SortSpec,
    output: Output,
}

/// Every size and tie rule in the order of blending, and one size composited; `few` sizes where other
/// layouts have all.
fn cases(strategy: &'static dyn SortStrategy, few: bool) -> Vec<Case> {
    let store = strategy.stores()[0];
    let limit = strategy.limit().unwrap_or(u32::MAX);
    let case = |max_frags, ties, output| Case {
        strategy,
        spec: SortSpec { min_frags: 0, max_frags, ties, store },
        output,
    };
    let mut cases = Vec::new();
    let sizes: &[u32] = if few { &[20, 64, 100] } else { &[1, 8, 20, 32, 64, 100, 160] };
    for max_frags in sizes.iter().copied().filter(|&n| n <= limit) {
        for ties in Ties::ALL {
            cases.push(case(max_frags, ties, Output::Emit));
        }
    }
    cases.push(case(limit.min(64), Ties::Total, Output::Composite));
    cases
}

fn source(case: &Case, layout: CudaLayout, pixels: u32) -> String {
    let Case { strategy, spec, output } = *case;
    let program = CudaProgram { layout, strategy, spec, output, pixels };
    program.source().expect("it assembles")
}

/// Whether what a program made is what its twin makes of the given fragments.
fn check(case: &Case, given: &Lfb, made: &[u8]) {
    let (strategy, spec) = (case.strategy, &case.spec);
    let mut scratch = Scratch::default();
    for pixel in 0..given.pixels() {
        let fragments = given.pixel(pixel);
        let name = format!("{} {spec:?}, pixel {pixel} of {}", strategy.name(), fragments.len());
        if case.output == Output::Composite {
            let expected = resolve(strategy, spec, fragments, &mut scratch);
            let found: [f32; 4] = bytemuck::pod_read_unaligned(&made[16 * pixel..16 * pixel + 16]);
            for (found, expected) in found.into_iter().zip(expected) {
                assert!((found - expected).abs() < 1e-5, "{name}: {found} and not {expected}");
            }
            continue;
        }
        let expected = sorted(strategy, spec, fragments, &mut scratch);
        let first = given.offsets()[pixel];
        let made = &made[8 * first..8 * (first + fragments.len())];
        let mut found: Vec<Fragment> = bytemuck::pod_collect_to_vec(made);
        let beyond = found.split_off(expected.len());
        assert!(beyond.iter().all(|f| f.key() == 0xCDCD_CDCD_CDCD_CDCD), "{name}: too many");
        if strategy.blends_from() == End::Back {
            found.reverse();
        }
        if spec.ties == Ties::Total || !strategy.sorts() {
            assert_eq!(found, expected, "{name}");
        } else {
            // Fragments of equal depth may come in any order.
            assert!(found.is_sorted_by_key(|f| f.depth_key), "{name}: out of order");
            found.sort_by_key(|f| f.key());
            let mut expected = expected.to_vec();
            expected.sort_by_key(|f| f.key());
            assert_eq!(found, expected, "{name}: not the same fragments");
        }
    }
}

/// The bytes of the buffers that a layout reads, and of where each pixel's fragments start.
fn buffers(capture: &'static dyn Capture, given: &Lfb) -> (Vec<Buffer>, Vec<u32>) {
    let names = layout(capture).buffers();
    let mut all = capture.upload(given);
    let named = names.into_iter().map(|name| {
        let place = all.iter().position(|buffer| buffer.name == name);
        all.swap_remove(place.unwrap_or_else(|| panic!("{} uploads no {name}", capture.name())))
    });
    let named = named.collect();
    (named, given.offsets().iter().map(|&offset| offset as u32).collect())
}

/// The fragments in the order in which the layout's reader meets them.
fn as_read(capture: &dyn Capture, given: &Lfb) -> Lfb {
    let mut read = given.clone();
    capture.order(&mut read);
    read
}

fn bytes(buffer: &Buffer) -> &[u8] {
    match &buffer.contents {
        Contents::Data(data) => data,
        Contents::Undefined => panic!("{}: an upload has contents", buffer.name),
    }
}

/// All programs of a strategy as one C++ program that runs them and saves what they make.
fn host_program(cases: &[Case], layout: CudaLayout, given: &Lfb, room: usize) -> String {
    let (pixels, total) = (given.pixels() as u32, given.fragments().len());
    let mut text = include_str!("support/cuda_host.h").to_owned();
    let mut main = String::from("int main() {\n");
    for name in layout.buffers().iter().chain(&["emit_offsets"]) {
        let _ = writeln!(main, "Buffer {name} = load(\"{name}\");");
    }
    for (place, case) in cases.iter().enumerate() {
        let program = source(case, layout, pixels).replace("extern \"C\"", "static");
        let _ = writeln!(text, "namespace p{place} {{\n{program}\n}}");
        let (bytes, offsets) = match case.output {
            Output::Emit => (8 * total, "emit_offsets, "),
            Output::Composite => (16 * pixels as usize, ""),
        };
        let inputs: Vec<String> = layout.buffers().iter().map(|name| format!("{name}, ")).collect();
        let _ = writeln!(
            main,
            "{{ Buffer made = poisoned({bytes});\n\
             for (blockIdx.x = 0; blockIdx.x < {blocks}; blockIdx.x++)\n\
             for (threadIdx.x = 0; threadIdx.x < {CUDA_THREADS}; threadIdx.x++)\n\
             p{place}::resolve({inputs}{room}, {offsets}made);\n\
             save(\"made{place}\", made); }}",
            inputs = inputs.concat(),
            blocks = pixels.div_ceil(CUDA_THREADS),
        );
    }
    text + &main + "}\n"
}

fn cpp_runs(folder: &Path, flags: &[&str], program: &str) {
    std::fs::write(folder.join("programs.cpp"), program).expect("it is written");
    let mut compile = Command::new("c++");
    compile.args(["-std=c++17", "-o", "programs", "programs.cpp"]).args(flags).current_dir(folder);
    for command in [&mut compile, Command::new("./programs").current_dir(folder)] {
        let output = command.output().expect("it starts");
        let text = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{command:?}: {}\n{text}", output.status);
    }
}

#[test]
fn every_kernel_sorts_as_its_twin_as_cpp() {
    if Command::new("c++").arg("--version").output().is_err() {
        eprintln!("SKIPPED: there is no C++ compiler");
        return;
    }
    let given = pixels();
    // OIT_CPP_FLAGS="-fsanitize=address,undefined" finds accesses out of bounds.
    let flags = std::env::var("OIT_CPP_FLAGS").unwrap_or_default();
    let flags: Vec<&str> = flags.split_whitespace().collect();
    assert!(layouts().len() >= 2);
    for (place, capture) in layouts().into_iter().enumerate() {
        let (buffers, offsets) = buffers(capture, &given);
        let read = as_read(capture, &given);
        for strategy in STRATEGIES.iter().filter(|strategy| strategy.cuda_template().is_some()) {
            let folder = tempfile::tempdir().expect("a temporary folder");
            let write = |name: &str, data: &[u8]| {
                std::fs::write(folder.path().join(name), data).expect("it is written");
            };
            buffers.iter().for_each(|buffer| write(&buffer.name, bytes(buffer)));
            write("emit_offsets", bytemuck::cast_slice(&offsets));
            let cases = cases(*strategy, place > 0);
            let room = given.fragments().len();
            cpp_runs(folder.path(), &flags, &host_program(&cases, layout(capture), &given, room));
            for (place, case) in cases.iter().enumerate() {
                let made = folder.path().join(format!("made{place}"));
                check(case, &read, &std::fs::read(made).expect("it was saved"));
            }
            println!("{} on {}: {} programs", strategy.name(), capture.name(), cases.len());
        }
    }
}

/// Runs a case on the GPU; what it made.
fn on_gpu(
    cuda: &mut Cuda,
    case: &Case,
    layout: CudaLayout,
    inputs: &[DeviceBuffer],
    offsets: &DeviceBuffer,
    given: &Lfb,
) -> Result<Vec<u8>, CudaError> {
    let (pixels, total) = (given.pixels() as u32, given.fragments().len());
    let label = format!("{} on {}", case.strategy.name(), layout.name);
    let kernel = cuda.kernel(&label, &source(case, layout, pixels), CUDA_KERNEL)?;
    let (bytes, more) = match case.output {
        Output::Emit => (8 * total, std::slice::from_ref(offsets)),
        Output::Composite => (16 * pixels as usize, &[][..]),
    };
    let mut made = cuda.allocate("made", bytes as u64)?;
    let blocks = (pixels.div_ceil(CUDA_THREADS), CUDA_THREADS);
    // SAFETY: these are the kernel's parameters, and the buffers hold all of its pixels.
    unsafe { cuda.run(&kernel, blocks, (inputs, total as u32, more), &mut made) }?;
    if case.output == Output::Emit {
        let (local, registers) = cuda.local_bytes_and_registers(&kernel)?;
        println!("{label}, {:?}: {local} bytes local, {registers} registers", case.spec);
    }
    cuda.read(&made)
}

#[test]
fn every_kernel_sorts_as_its_twin_on_the_gpu() {
    let given = pixels();
    let cache = support::cache();
    for id in support::gpus() {
        let device = oit_gpu::open(&id, cache.path()).expect("a listed device opens");
        let Some(uuid) = device.uuid() else { continue };
        let mut cuda = match Cuda::open(uuid) {
            Ok(cuda) => cuda,
            Err(CudaError::Missing(reason)) => {
                eprintln!("SKIPPED: {id}: {reason}");
                continue;
            }
            Err(error) => panic!("{id}: {error}"),
        };
        for (place, capture) in layouts().into_iter().enumerate() {
            let (buffers, offsets) = buffers(capture, &given);
            let read = as_read(capture, &given);
            let upload = |name: &str, bytes: &[u8]| cuda.upload(name, bytes).expect("it has room");
            let inputs: Vec<DeviceBuffer> =
                buffers.iter().map(|buffer| upload(&buffer.name, bytes(buffer))).collect();
            let offsets = upload("emit_offsets", bytemuck::cast_slice(&offsets));
            for strategy in STRATEGIES.iter().filter(|strategy| strategy.cuda_template().is_some())
            {
                for case in cases(*strategy, place > 0) {
                    let layout = layout(capture);
                    let made = on_gpu(&mut cuda, &case, layout, &inputs, &offsets, &given);
                    check(&case, &read, &made.unwrap_or_else(|error| panic!("{id}: {error}")));
                }
            }
        }
    }
}
