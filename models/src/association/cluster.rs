//! Connected components of the graph "track – plot in its gate" by union–find.

use super::nearest::Pair;

/// Work space that cuts gated pairs into clusters; no hypothesis crosses a cluster's border.
#[derive(Clone, Debug, Default)]
pub struct Clusters {
    parent: Vec<u32>,
    order: Vec<u32>,
    starts: Vec<u32>,
}

impl Clusters {
    /// Reorders `pairs` (sorted by track, then plot) so that each cluster is contiguous, clusters in
    /// the order of their first track, pairs within a cluster in the order they came. Returns the
    /// borders: cluster `k` is `pairs[borders[k]..borders[k + 1]]`.
    pub fn cut(
        &mut self,
        tracks: usize,
        plots: usize,
        pairs: &mut [Pair],
        scratch: &mut Vec<Pair>,
    ) -> &[u32] {
        self.parent.clear();
        self.parent.extend(0..(tracks + plots) as u32);
        for pair in pairs.iter() {
            let a = self.root(pair.track);
            let b = self.root(tracks as u32 + pair.plot);
            // The smaller index is the root: a cluster's root is its first track.
            let (low, high) = if a < b { (a, b) } else { (b, a) };
            self.parent[high as usize] = low;
        }
        // Counting sort by root; roots are tracks, as every pair has one.
        self.order.clear();
        self.order.resize(tracks + 1, 0);
        for pair in pairs.iter() {
            let root = self.root(pair.track) as usize;
            self.order[root + 1] += 1;
        }
        self.starts.clear();
        let mut sum = 0;
        for slot in &mut self.order {
            let count = *slot;
            if count > 0 {
                self.starts.push(sum);
            }
            sum += count;
            *slot = sum;
        }
        self.starts.push(sum);
        scratch.clear();
        scratch.extend_from_slice(pairs);
        for &pair in scratch.iter() {
            let root = self.root(pair.track) as usize;
            pairs[self.order[root] as usize] = pair;
            self.order[root] += 1;
        }
        &self.starts
    }

    fn root(&mut self, mut node: u32) -> u32 {
        while self.parent[node as usize] != node {
            let up = self.parent[self.parent[node as usize] as usize];
            self.parent[node as usize] = up;
            node = up;
        }
        node
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::filter::Nis;

    #[test]
    fn components_are_contiguous_and_complete() {
        let pair = |track, plot| Pair { track, plot, nis: Nis { d2: 0.0, det: 1.0, dof: 2 } };
        let mut pairs =
            vec![pair(0, 3), pair(1, 0), pair(2, 3), pair(3, 1), pair(3, 0), pair(5, 4)];
        let mut clusters = Clusters::default();
        let borders = clusters.cut(6, 5, &mut pairs, &mut Vec::new()).to_vec();
        let found: Vec<Vec<(u32, u32)>> = borders
            .windows(2)
            .map(|w| {
                pairs[w[0] as usize..w[1] as usize].iter().map(|p| (p.track, p.plot)).collect()
            })
            .collect();
        assert_eq!(found, [vec![(0, 3), (2, 3)], vec![(1, 0), (3, 1), (3, 0)], vec![(5, 4)]]);
    }
}
