// Puts into SUMS, for each of VALUES, the sum of those before it. 256 invocations scan a block, four
// values each.
//
// STATUS holds a word a block: nothing (0), or the sum of the block, or the sum of all values up to
// the block's end. The two bits that say which are the highest, so that the greater word is the one
// that says more. A last word counts the tickets.
const SUM_OF_BLOCK = 0x40000000u;
const SUM_UP_TO = 0x80000000u;
const SUM_MASK = 0x3fffffffu;

// How often a word is read before its block is added up here.
const POLLS = 16u;

@group(0) @binding(0) var<storage, read> VALUES: array<u32>;
@group(0) @binding(1) var<storage, read_write> SUMS: array<u32>;
@group(0) @binding(2) var<storage, read_write> TOTAL: array<u32>;
@group(0) @binding(3) var<storage, read_write> STATUS: array<atomic<u32>>;

var<workgroup> ticket: u32;
var<workgroup> partial: array<u32, 256>;
var<workgroup> nearest_up_to: atomic<u32>;
var<workgroup> nearest_missing: atomic<u32>;
var<workgroup> window_sum: atomic<u32>;
var<workgroup> window: vec2<u32>;

// Reads the words of up to 256 blocks before the block `end`, one an invocation, the nearest first,
// and adds up those from which the sum before `end` is known to follow. Gives how many blocks that
// were, and 1 if nothing is left to add.
fn look_back(lane: u32, end: u32) -> vec2<u32> {
    if (lane == 0u) {
        atomicStore(&nearest_up_to, 256u);
        atomicStore(&nearest_missing, 256u);
        atomicStore(&window_sum, 0u);
    }
    workgroupBarrier();
    // Before the first block the sum is known to be nothing.
    var word = SUM_UP_TO;
    if (lane < end) {
        word = 0u;
        for (var poll = 0u; poll < POLLS && word == 0u; poll++) {
            word = atomicLoad(&STATUS[end - 1u - lane]);
        }
    }
    if (word >= SUM_UP_TO) {
        atomicMin(&nearest_up_to, lane);
    } else if (word == 0u) {
        atomicMin(&nearest_missing, lane);
    }
    workgroupBarrier();
    let up_to = atomicLoad(&nearest_up_to);
    let blocks = min(up_to + 1u, atomicLoad(&nearest_missing));
    if (lane < blocks) {
        atomicAdd(&window_sum, word & SUM_MASK);
    }
    if (lane == 0u) {
        window = vec2<u32>(blocks, u32(blocks == up_to + 1u));
    }
    return workgroupUniformLoad(&window);
}

// Adds up a block whose sum is missing, for its owner. Whoever is first publishes the same sum, and
// what says more than that stays.
fn add_up(lane: u32, block: u32) {
    var sum = 0u;
    for (var i = 0u; i < 4u; i++) {
        let at = block * 1024u + i * 256u + lane;
        if (at < LENGTH) {
            sum += VALUES[at];
        }
    }
    partial[lane] = sum;
    for (var half = 128u; half > 0u; half /= 2u) {
        workgroupBarrier();
        if (lane < half) {
            partial[lane] += partial[lane + half];
        }
    }
    if (lane == 0u) {
        atomicMax(&STATUS[block], SUM_OF_BLOCK | partial[0]);
    }
}

@compute @workgroup_size(256)
fn main(@builtin(local_invocation_index) lane: u32) {
    // Blocks are handed out in the order in which workgroups start.
    if (lane == 0u) {
        ticket = atomicAdd(&STATUS[BLOCKS], 1u);
    }
    let block = workgroupUniformLoad(&ticket);
    if (block >= BLOCKS) {
        return;
    }
    let first = block * 1024u + lane * 4u;
    var values: array<u32, 4>;
    var own = 0u;
    for (var i = 0u; i < 4u; i++) {
        // Written in any case: an array holds anything before that.
        values[i] = 0u;
        if (first + i < LENGTH) {
            values[i] = VALUES[first + i];
        }
        own += values[i];
    }
    // Hillis and Steele: after the step of `reach`, each sum covers the 2 * reach values up to it.
    var sum = own;
    for (var reach = 1u; reach < 256u; reach *= 2u) {
        partial[lane] = sum;
        workgroupBarrier();
        if (lane >= reach) {
            sum += partial[lane - reach];
        }
        workgroupBarrier();
    }
    // The last invocation's sum is the block's.
    if (lane == 255u) {
        atomicMax(&STATUS[block], SUM_OF_BLOCK | sum);
    }

    var before = 0u;
    var end = block;
    loop {
        let window = look_back(lane, end);
        before += atomicLoad(&window_sum);
        if (window.y == 1u) {
            break;
        }
        end -= window.x;
        if (window.x < 256u) {
            add_up(lane, end - 1u);
        }
        // All have read the sum of this window before it is reset for the next.
        workgroupBarrier();
    }
    if (lane == 255u) {
        atomicMax(&STATUS[block], SUM_UP_TO | (before + sum));
        if (block == BLOCKS - 1u) {
            TOTAL[0] = before + sum;
        }
    }
    var at = before + sum - own;
    for (var i = 0u; i < 4u; i++) {
        if (first + i < LENGTH) {
            SUMS[first + i] = at;
        }
        at += values[i];
    }
}
