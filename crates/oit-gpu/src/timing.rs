//! From the passes of a plan to timestamps, and from timestamps to the time of each stage.

use crate::{Part, Plan, Timing};
use std::ops::Range;

/// The runs of consecutive passes that share a stage and a part of it. A backend takes one timestamp
/// before the first run and one after each.
#[derive(Clone, Debug)]
pub(crate) struct Stages {
    /// The passes of each run.
    pub(crate) runs: Vec<Range<usize>>,
    stage_of_run: Vec<(usize, Option<u32>)>,
    names: Vec<&'static str>,
}

/// How a device counts time.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) struct Clock {
    /// The bits of a timestamp that are valid.
    pub(crate) mask: u64,
    /// Nanoseconds of one tick.
    pub(crate) period_ns: f64,
}

impl Clock {
    /// Whole nanoseconds from one timestamp to a later one; the counter may wrap around between.
    fn elapsed_ns(self, from: u64, to: u64) -> u64 {
        let ticks = to.wrapping_sub(from) & self.mask;
        (ticks as f64 * self.period_ns).round() as u64
    }
}

impl Stages {
    pub(crate) fn new(plan: &Plan) -> Self {
        let names = plan.stages();
        let mut runs: Vec<Range<usize>> = Vec::new();
        let mut stage_of_run = Vec::new();
        for (index, pass) in plan.passes.iter().enumerate() {
            let stage = names.iter().position(|&name| name == pass.stage).unwrap_or_default();
            let own = (stage, pass.part);
            match runs.last_mut() {
                Some(run) if stage_of_run.last() == Some(&own) => run.end = index + 1,
                _ => {
                    runs.push(index..index + 1);
                    stage_of_run.push(own);
                }
            }
        }
        Self { runs, stage_of_run, names }
    }

    /// How many timestamps a run of the plan takes.
    pub(crate) fn stamps(&self) -> u32 {
        self.runs.len() as u32 + 1
    }

    /// The times that these timestamps say, `stamps()` of them.
    pub(crate) fn timing(&self, ticks: &[u64], clock: Clock) -> Timing {
        let mut stages: Vec<_> = self.names.iter().map(|&name| (name, 0)).collect();
        let mut parts: Vec<(Part, u64)> = Vec::new();
        for (&(stage, part), pair) in self.stage_of_run.iter().zip(ticks.windows(2)) {
            let ns = clock.elapsed_ns(pair[0], pair[1]);
            stages[stage].1 += ns;
            let Some(part) = part else { continue };
            let part = (self.names[stage], part);
            match parts.iter_mut().find(|(known, _)| *known == part) {
                Some((_, sum)) => *sum += ns,
                None => parts.push((part, ns)),
            }
        }
        let total_ns = match ticks {
            [first, .., last] => clock.elapsed_ns(*first, *last),
            _ => 0,
        };
        Timing { stages, parts, total_ns }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Pass;

    #[test]
    fn passes_of_a_stage_are_one_interval_and_recurring_stages_add_up() {
        let passes = ["clear", "clear", "count", "clear", "resolve"];
        let plan = Plan {
            passes: passes.into_iter().map(|stage| Pass::clear(stage, "b")).collect(),
            ..Plan::default()
        };
        let stages = Stages::new(&plan);
        assert_eq!(stages.runs, [0..2, 2..3, 3..4, 4..5]);
        assert_eq!(stages.stamps(), 5);
        // A 36-bit counter that wraps around inside `count`.
        let clock = Clock { mask: (1 << 36) - 1, period_ns: 2.5 };
        let top = 1 << 36;
        let timing = stages.timing(&[top - 20, top - 10, 30, 37, 47], clock);
        assert_eq!(timing.stages, [("clear", 25 + 18), ("count", 100), ("resolve", 25)]);
        assert_eq!(timing.total_ns, 168);
        assert_eq!(timing.parts, []);
    }

    #[test]
    fn parts_of_a_stage_are_timed_apart_and_add_up_to_it() {
        let pass = |stage, part: Option<u32>| Pass { part, ..Pass::clear(stage, "b") };
        let parts = [("group", None), ("resolve", Some(8)), ("resolve", Some(16))];
        let again = [("resolve", Some(16)), ("group", None), ("resolve", Some(8))];
        let passes = parts.into_iter().chain(again).map(|(stage, part)| pass(stage, part));
        let stages = Stages::new(&Plan { passes: passes.collect(), ..Plan::default() });
        assert_eq!(stages.runs, [0..1, 1..2, 2..4, 4..5, 5..6]);
        let clock = Clock { mask: u64::MAX, period_ns: 1.0 };
        let timing = stages.timing(&[0, 1, 11, 111, 113, 1113], clock);
        assert_eq!(timing.stages, [("group", 3), ("resolve", 1110)]);
        assert_eq!(timing.parts, [(("resolve", 8), 1010), (("resolve", 16), 100)]);
    }
}
