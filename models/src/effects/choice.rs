//! Which level of each effect: the set that saves most time while the sum of all losses is tolerated.
//!
//! Depth first over the ladders, those with the largest saving first, bounded by what the rest could
//! still save. Losses only grow when they are added, so what is not tolerated needs no children.

/// A loss that adds up; no part is negative.
pub trait Sum: Clone {
    /// No loss.
    const NONE: Self;
    /// Whether nothing is lost.
    fn is_none(&self) -> bool;
    /// Both together.
    #[must_use]
    fn plus(&self, other: &Self) -> Self;
}

/// One level of an effect as the choice sees it.
#[derive(Clone, Debug, PartialEq)]
pub struct Candidate<L> {
    /// What it costs, whole nanoseconds.
    pub cost_ns: u32,
    /// What it loses against the most exact level.
    pub loss: L,
}

/// A choice of one candidate of each ladder.
#[derive(Clone, Debug, PartialEq)]
pub struct Choice<L> {
    /// Place of the chosen candidate of each ladder.
    pub chosen: Vec<usize>,
    /// Sum of the costs, ns.
    pub cost_ns: u64,
    /// Sum of the losses.
    pub loss: L,
    /// Whether no cheaper choice is tolerated; else the search was cut short.
    pub is_best: bool,
}

/// Nodes of the search before what was found so far stands.
pub const MOST_NODES: u32 = 4096;

/// Margin on shares of a tolerance, against rounding.
pub const MARGIN: f64 = 1e-9;

/// The cheapest tolerated choice. `None` where not even the last candidate of each ladder, the most
/// exact one, is tolerated.
///
/// `within` tells whether a sum of losses is tolerated; `share` how much of the tolerance one loss takes
/// by itself (only for the order of the search).
pub fn cheapest<L: Sum>(
    ladders: &[Vec<Candidate<L>>],
    mut within: impl FnMut(&L) -> bool,
    share: impl Fn(&L) -> f64,
) -> Option<Choice<L>> {
    // What loses nothing is no candidate: the cheapest of it is taken from the start.
    let exact: Vec<usize> = ladders.iter().map(|ladder| free(ladder)).collect();
    let sum = |chosen: &[usize]| {
        ladders.iter().zip(chosen).fold((0u64, L::NONE), |(cost, loss), (ladder, &i)| {
            (cost + u64::from(ladder[i].cost_ns), loss.plus(&ladder[i].loss))
        })
    };
    let (cost_ns, loss) = sum(&exact);
    if !within(&loss) {
        return None;
    }
    let mut search = Search::new(ladders);
    // A greedy choice first: it cuts most of the tree.
    let greedy = greedy(ladders, &exact, &mut within, &share);
    let (greedy_ns, greedy_loss) = sum(&greedy);
    let best = if greedy_ns < cost_ns {
        Choice { chosen: greedy, cost_ns: greedy_ns, loss: greedy_loss, is_best: true }
    } else {
        Choice { chosen: exact, cost_ns, loss, is_best: true }
    };
    search.best = Some(best);
    search.go(0, 0, &L::NONE, &mut within);
    let found = search.nodes <= MOST_NODES;
    search.best.map(|best| Choice { is_best: found, ..best })
}

/// The cheapest candidate without loss; of several, the first.
fn free<L: Sum>(ladder: &[Candidate<L>]) -> usize {
    let none = (0..ladder.len()).filter(|&i| ladder[i].loss.is_none());
    none.min_by_key(|&i| ladder[i].cost_ns).unwrap_or(ladder.len() - 1)
}

/// The most saved time per share first.
fn greedy<L: Sum>(
    ladders: &[Vec<Candidate<L>>],
    exact: &[usize],
    within: &mut impl FnMut(&L) -> bool,
    share: &impl Fn(&L) -> f64,
) -> Vec<usize> {
    let mut worth: Vec<(f64, usize, usize)> = Vec::new();
    for (l, ladder) in ladders.iter().enumerate() {
        let dearest = f64::from(ladder[exact[l]].cost_ns);
        for (i, candidate) in ladder.iter().enumerate().take(ladder.len() - 1) {
            let saved = dearest - f64::from(candidate.cost_ns);
            let used = share(&candidate.loss);
            if saved > 0.0 && used.is_finite() {
                worth.push((saved / used.max(1e-6), l, i));
            }
        }
    }
    worth.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)).then(a.2.cmp(&b.2)));
    let mut chosen = exact.to_vec();
    for (_, l, i) in worth {
        if ladders[l][i].cost_ns >= ladders[l][chosen[l]].cost_ns {
            continue;
        }
        let before = std::mem::replace(&mut chosen[l], i);
        let both = ladders.iter().zip(&chosen);
        if !within(&both.fold(L::NONE, |sum, (ladder, &i)| sum.plus(&ladder[i].loss))) {
            chosen[l] = before;
        }
    }
    chosen
}

struct Search<'a, L> {
    ladders: &'a [Vec<Candidate<L>>],
    /// Ladders in the order of the search, and their candidates, cheapest first.
    order: Vec<(usize, Vec<usize>)>,
    /// Least cost of the ladders from a place of the order on.
    least_ns: Vec<u64>,
    chosen: Vec<usize>,
    best: Option<Choice<L>>,
    nodes: u32,
}

impl<'a, L: Sum> Search<'a, L> {
    fn new(ladders: &'a [Vec<Candidate<L>>]) -> Self {
        let mut order: Vec<(usize, Vec<usize>)> = Vec::with_capacity(ladders.len());
        for (l, ladder) in ladders.iter().enumerate() {
            let mut places: Vec<usize> = (0..ladder.len()).collect();
            // The one that loses nothing first where two cost the same.
            places.sort_by_key(|&i| (ladder[i].cost_ns, !ladder[i].loss.is_none(), i));
            order.push((l, places));
        }
        let saving = |l: usize| {
            let costs = ladders[l].iter().map(|c| c.cost_ns);
            let last = ladders[l][ladders[l].len() - 1].cost_ns;
            u32::MAX - last.saturating_sub(costs.min().unwrap_or(0))
        };
        order.sort_by_key(|(l, _)| (saving(*l), *l));
        let mut least_ns = vec![0; ladders.len() + 1];
        for (place, (l, places)) in order.iter().enumerate().rev() {
            let least = places.first().map_or(0, |&i| u64::from(ladders[*l][i].cost_ns));
            least_ns[place] = least_ns[place + 1] + least;
        }
        Self { ladders, order, least_ns, chosen: vec![0; ladders.len()], best: None, nodes: 0 }
    }

    fn go(&mut self, place: usize, cost_ns: u64, loss: &L, within: &mut impl FnMut(&L) -> bool) {
        let cheaper =
            |best: &Option<Choice<L>>, cost| best.as_ref().is_none_or(|b| cost < b.cost_ns);
        if place == self.order.len() {
            if cheaper(&self.best, cost_ns) {
                let chosen = self.chosen.clone();
                self.best = Some(Choice { chosen, cost_ns, loss: loss.clone(), is_best: true });
            }
            return;
        }
        for n in 0..self.order[place].1.len() {
            let (l, i) = (self.order[place].0, self.order[place].1[n]);
            let candidate = &self.ladders[l][i];
            let cost = cost_ns + u64::from(candidate.cost_ns);
            if !cheaper(&self.best, cost + self.least_ns[place + 1]) {
                // The candidates behind it cost no less.
                return;
            }
            self.nodes += 1;
            if self.nodes > MOST_NODES {
                return;
            }
            let sum = loss.plus(&candidate.loss);
            if within(&sum) {
                self.chosen[l] = i;
                self.go(place + 1, cost, &sum, within);
            }
        }
    }
}

/// The least factor on the tolerance, up to `most`, at which a cost stays within a budget: by
/// bisection, `cost` being the cost of the cheapest choice at a factor, which never grows with it, and
/// the share that this choice takes. `None` where even `most` costs more.
pub fn least_factor(
    budget_ns: f64,
    most: f64,
    mut cost: impl FnMut(f64) -> (f64, f64),
) -> Option<f64> {
    let fits = |ns: f64| ns <= budget_ns;
    let (ns, share) = cost(most);
    if !fits(ns) {
        return None;
    }
    let (mut low, mut high) = (0.0, share.min(most));
    let (ns, share) = cost(low);
    if fits(ns) {
        return Some(share.min(low));
    }
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high || high - low < 1e-13 * high {
            break;
        }
        let (ns, share) = cost(middle);
        if fits(ns) {
            // The steps are where a share is used up.
            high = share.min(middle);
        } else {
            low = middle;
        }
    }
    Some(high)
}
