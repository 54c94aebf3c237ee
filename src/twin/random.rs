//! Random numbers that are the same in every run.

use glam::DVec3;

/// SplitMix64 (Steele et al. 2014).
pub struct Random(u64);

impl Random {
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    pub fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let a = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let b = (a ^ (a >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        b ^ (b >> 31)
    }

    /// 0 to `end` - 1.
    pub fn below(&mut self, end: u32) -> u32 {
        (self.next() % u64::from(end)) as u32
    }

    /// Uniform in [0, 1).
    pub fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Uniform in [low, high).
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// True with the given probability.
    pub fn chance(&mut self, probability: f64) -> bool {
        self.unit() < probability
    }

    /// Uniform in the unit cube.
    pub fn point(&mut self) -> DVec3 {
        DVec3::new(self.unit(), self.unit(), self.unit())
    }

    /// Uniform on the unit sphere.
    pub fn direction(&mut self) -> DVec3 {
        let z = self.between(-1.0, 1.0);
        let (sin, cos) = self.between(0.0, std::f64::consts::TAU).sin_cos();
        let r = (1.0 - z * z).sqrt();
        DVec3::new(r * cos, r * sin, z)
    }
}

/// Twin of lib/random.wgsl `pcg`.
pub fn pcg(value: u32) -> u32 {
    let state = value.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
    let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
    (word >> 22) ^ word
}

/// Twin of lib/random.wgsl `unit_float`.
pub fn unit_float(hash: u32) -> f64 {
    f64::from(hash >> 8) / 16_777_216.0
}

/// Errors of the size of f32 rounding, to see which results hang on them; or none.
pub struct Errors {
    size: f64,
    state: std::cell::RefCell<Random>,
}

impl Errors {
    pub fn none() -> Self {
        Self { size: 0.0, state: std::cell::RefCell::new(Random::new(0)) }
    }

    pub fn seeded(seed: u64) -> Self {
        Self { size: 1.0, state: std::cell::RefCell::new(Random::new(seed)) }
    }

    /// `value` within +- `error`.
    pub fn on(&self, value: f64, error: f64) -> f64 {
        if self.size == 0.0 { value } else { value + self.state.borrow_mut().between(-error, error) }
    }

    /// Each component of `value` within +- `error`.
    pub fn on3(&self, value: DVec3, error: f64) -> DVec3 {
        DVec3::new(self.on(value.x, error), self.on(value.y, error), self.on(value.z, error))
    }
}
