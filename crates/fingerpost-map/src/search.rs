//! Shortest paths over the road graph: A* on directed segments.
//!
//! The states are steps (a segment gone along in a direction), not nodes, so that turning round on the spot is known
//! and left to dead ends. Hart, Nilsson, Raphael 1968 with the straight-line distance, which never overestimates here
//! because lengths are straight-line distances in the same plane. Of equally long paths the one whose states come first
//! in the graph wins, every time.

use std::cmp::Ordering;
use std::collections::{BTreeMap, BinaryHeap};

use nalgebra::Point2;

use crate::{Direction, RoadGraph, RoadNode, Snap};

/// A segment gone along in a direction.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Step {
    pub(crate) segment: usize,
    pub(crate) direction: Direction,
}

impl Step {
    pub(crate) fn reversed(self) -> Self {
        let direction = match self.direction {
            Direction::Forward => Direction::Backward,
            Direction::Backward => Direction::Forward,
        };
        Self { direction, ..self }
    }
}

/// A place on a step, counted from where the step begins.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct OnStep {
    pub(crate) step: Step,
    pub(crate) along_m: f64,
}

/// A path between two places on steps: from the first step's place to the last step's.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Leg {
    pub(crate) steps: Vec<Step>,
    pub(crate) from: OnStep,
    pub(crate) to: OnStep,
    pub(crate) length_m: f64,
}

/// Nearer than this to a node, a place is the node, metres: a tenth of the map's own resolution.
const AT_NODE_M: f64 = 0.001;

/// The node that a place on a segment (distance from the segment's start) coincides with.
pub(crate) fn node_at(graph: &RoadGraph, segment: usize, along_m: f64) -> Option<usize> {
    let road = graph.segments()[segment];
    if along_m < AT_NODE_M {
        Some(road.start)
    } else if road.length_m - along_m < AT_NODE_M {
        Some(road.end)
    } else {
        None
    }
}

/// The permitted ways of setting out from a place.
pub(crate) fn departures(graph: &RoadGraph, snap: &Snap) -> Vec<OnStep> {
    match node_at(graph, snap.segment, snap.along_m) {
        Some(node) => steps_from(graph, node).map(|step| OnStep { step, along_m: 0.0 }).collect(),
        None => on_steps(graph, snap),
    }
}

/// The permitted ways of coming to a place.
pub(crate) fn arrivals(graph: &RoadGraph, snap: &Snap) -> Vec<OnStep> {
    let Some(node) = node_at(graph, snap.segment, snap.along_m) else { return on_steps(graph, snap) };
    let permitted = |step: &Step| graph.permits(step.segment, step.direction);
    let ends_here = |&segment: &usize| Step { segment, direction: graph.away_from(segment, node) }.reversed();
    let length_m = |step: Step| graph.segments()[step.segment].length_m;
    let steps = graph.nodes()[node].segments.iter().map(ends_here).filter(permitted);
    steps.map(|step| OnStep { step, along_m: length_m(step) }).collect()
}

/// A place on its segment, in each permitted direction.
pub(crate) fn on_steps(graph: &RoadGraph, snap: &Snap) -> Vec<OnStep> {
    let length_m = graph.segments()[snap.segment].length_m;
    [(Direction::Forward, snap.along_m), (Direction::Backward, length_m - snap.along_m)]
        .into_iter()
        .filter(|(direction, _)| graph.permits(snap.segment, *direction))
        .map(|(direction, along_m)| OnStep { step: Step { segment: snap.segment, direction }, along_m })
        .collect()
}

fn steps_from(graph: &RoadGraph, node: usize) -> impl Iterator<Item = Step> {
    graph.nodes()[node]
        .segments
        .iter()
        .map(move |&segment| Step { segment, direction: graph.away_from(segment, node) })
        .filter(|step| graph.permits(step.segment, step.direction))
}

/// Where a search aims, which orders what it looks at first.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Aim {
    /// All goals are this place (metres in the graph's plane); the search ends at the first one reached.
    Place(Point2<f64>),
    /// Goals lie here and there; all of them within this path length are wanted, metres.
    Within(f64),
}

/// Shortest legs from any of `starts` to each goal, in the order of `goals`; `None` for those not reached.
pub(crate) fn shortest(graph: &RoadGraph, starts: &[OnStep], goals: &[OnStep], aim: Aim) -> Vec<Option<Leg>> {
    let mut search = Search {
        graph,
        goals,
        aim,
        open: BinaryHeap::new(),
        came_from: BTreeMap::new(),
        legs: vec![None; goals.len()],
    };
    for (index, start) in starts.iter().enumerate() {
        let left_m = graph.segments()[start.step.segment].length_m - start.along_m;
        search.offer(left_m, State::Head(start.step), Origin::Start(index));
        for (goal_index, goal) in goals.iter().enumerate() {
            if goal.step == start.step && goal.along_m >= start.along_m {
                search.offer(goal.along_m - start.along_m, State::Goal(goal_index), Origin::Start(index));
            }
        }
    }
    search.run(starts);
    search.legs
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum State {
    /// A goal is reached.
    Goal(usize),
    /// The end of a step is reached.
    Head(Step),
}

#[derive(Debug, Clone, Copy)]
enum Origin {
    Start(usize),
    Step(Step),
}

struct Open {
    estimate_m: f64,
    cost_m: f64,
    state: State,
    origin: Origin,
}

impl Ord for Open {
    // Reversed, so that the heap's greatest is the nearest.
    fn cmp(&self, other: &Self) -> Ordering {
        other.estimate_m.total_cmp(&self.estimate_m).then_with(|| other.state.cmp(&self.state))
    }
}

impl PartialOrd for Open {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Open {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Open {}

struct Search<'a> {
    graph: &'a RoadGraph,
    goals: &'a [OnStep],
    aim: Aim,
    open: BinaryHeap<Open>,
    came_from: BTreeMap<Step, Origin>,
    legs: Vec<Option<Leg>>,
}

impl Search<'_> {
    fn offer(&mut self, cost_m: f64, state: State, origin: Origin) {
        let ahead_m = match (state, self.aim) {
            (State::Head(step), Aim::Place(place)) => {
                let head = self.graph.head(step.segment, step.direction);
                (self.graph.nodes()[head].p_in_map - place).norm()
            }
            _ => 0.0,
        };
        if let Aim::Within(limit_m) = self.aim
            && cost_m > limit_m
        {
            return;
        }
        self.open.push(Open { estimate_m: cost_m + ahead_m, cost_m, state, origin });
    }

    fn run(&mut self, starts: &[OnStep]) {
        let mut missing = self.goals.len();
        while let Some(Open { cost_m, state, origin, .. }) = self.open.pop() {
            match state {
                State::Goal(index) if self.legs[index].is_none() => {
                    self.legs[index] = Some(self.leg(starts, origin, self.goals[index], cost_m));
                    missing -= 1;
                    if missing == 0 || matches!(self.aim, Aim::Place(_)) {
                        return;
                    }
                }
                State::Head(step) if !self.came_from.contains_key(&step) => {
                    self.came_from.insert(step, origin);
                    self.expand(step, cost_m);
                }
                _ => {}
            }
        }
    }

    fn expand(&mut self, step: Step, cost_m: f64) {
        let graph = self.graph;
        let node = graph.head(step.segment, step.direction);
        let RoadNode { segments, is_closed, .. } = &graph.nodes()[node];
        // At an end and before a barrier one turns back, elsewhere one goes on.
        let turns_back = segments.len() == 1 || *is_closed;
        for next in steps_from(graph, node) {
            if (next.segment == step.segment) != turns_back {
                continue;
            }
            for (index, goal) in self.goals.iter().enumerate().filter(|(_, goal)| goal.step == next) {
                self.offer(cost_m + goal.along_m, State::Goal(index), Origin::Step(step));
            }
            let length_m = graph.segments()[next.segment].length_m;
            self.offer(cost_m + length_m, State::Head(next), Origin::Step(step));
        }
    }

    fn leg(&self, starts: &[OnStep], mut origin: Origin, goal: OnStep, length_m: f64) -> Leg {
        let mut steps = vec![goal.step];
        let start = loop {
            match origin {
                Origin::Start(index) => break index,
                Origin::Step(step) => {
                    steps.push(step);
                    origin = self.came_from[&step];
                }
            }
        };
        steps.reverse();
        Leg { steps, from: starts[start], to: goal, length_m }
    }
}
