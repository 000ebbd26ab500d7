//! Random numbers from a seed, the same ones everywhere and always.

/// SplitMix64 (Steele, Lea, Flood 2014): the same numbers everywhere and always.
pub struct Random(pub(super) u64);

impl Random {
    /// Numbers of seeds side by side have nothing in common.
    pub fn new(seed: u64) -> Self {
        Self(Self(seed).next())
    }

    pub(super) fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// At least `low`, and less than `end`.
    pub fn integer(&mut self, low: usize, end: usize) -> usize {
        low + (self.next() % (end - low) as u64) as usize
    }

    /// From 0 to 1.
    pub fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// Fisher and Yates.
pub(super) fn permutation(count: usize, random: &mut Random) -> Vec<usize> {
    let mut order: Vec<usize> = (0..count).collect();
    for last in (1..count).rev() {
        order.swap(last, (random.next() % (last as u64 + 1)) as usize);
    }
    order
}
