//! Lists of indices in two flat arrays (compressed sparse rows).

/// A list of entries for each key.
pub(super) struct IndexLists {
    /// Where each list starts, and where the last one ends.
    starts: Vec<u32>,
    entries: Vec<u32>,
}

impl IndexLists {
    /// From pairs of a key below `count` and an entry. `pairs` is called twice. O(count + pairs).
    pub(super) fn new<I: Iterator<Item = (u32, u32)>>(count: usize, pairs: impl Fn() -> I) -> Self {
        let mut starts = vec![0_u32; count + 1];
        pairs().for_each(|(key, _)| starts[key as usize + 1] += 1);
        let mut total = 0;
        for start in &mut starts {
            total += *start;
            *start = total;
        }
        let mut next = starts.clone();
        let mut entries = vec![0; total as usize];
        for (key, entry) in pairs() {
            entries[next[key as usize] as usize] = entry;
            next[key as usize] += 1;
        }
        Self { starts, entries }
    }

    /// Length of the longest list.
    pub(super) fn longest(&self) -> usize {
        self.starts.windows(2).map(|pair| (pair[1] - pair[0]) as usize).max().unwrap_or(0)
    }

    pub(super) fn of(&self, key: u32) -> &[u32] {
        let [start, end] = [key, key + 1].map(|key| self.starts[key as usize] as usize);
        &self.entries[start..end]
    }
}
