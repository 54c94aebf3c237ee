//! How far an image of E_ind is from the path-traced truth, with the truth's own noise removed.

use crate::image::{Image, luminance};

/// Softens the relative error in the dark: this share of the squared mean is added to the denominator.
const DARK: f64 = 0.01;

/// Scores on luminance over the pixels where something was hit. `None` where the truth is exactly zero.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Score {
    /// mean((X-A)(X-B) / (M^2 + 0.01 mean(M)^2)), unbiased by the halves A and B of the truth; M is their mean.
    pub rel_mse: Option<f64>,
    /// sqrt(max(0, mean((X-A)(X-B)))) / mean(M).
    pub nrmse: Option<f64>,
    /// mean(X) / mean(M) - 1.
    pub bias: Option<f64>,
    /// mean(X).
    pub mean: f64,
    /// Largest |X - M|.
    pub max_abs: f64,
    /// The same measure of the truth's own noise: mean(((A-B)/2)^2 / (M^2 + ...)).
    pub reference_noise: Option<f64>,
}

/// Scores `image` against the two independent halves of the truth; all four images have one size, which is what
/// `None` stands for when it is not so. `hit` tells which pixels count.
pub fn score(image: &Image, half_a: &Image, half_b: &Image, hit: &Image<bool>) -> Option<Score> {
    let count = image.pixels.len();
    if [half_a.pixels.len(), half_b.pixels.len(), hit.pixels.len()] != [count; 3] {
        return None;
    }
    let samples: Vec<[f64; 3]> = (0..count)
        .filter(|i| hit.pixels[*i])
        .map(|i| [image, half_a, half_b].map(|image| luminance(image.pixels[i])))
        .collect();
    (!samples.is_empty()).then(|| score_samples(&samples))
}

fn score_samples(samples: &[[f64; 3]]) -> Score {
    let mean = |f: &dyn Fn(&[f64; 3]) -> f64| samples.iter().map(f).sum::<f64>() / samples.len() as f64;
    let truth = |s: &[f64; 3]| (s[1] + s[2]) / 2.0;
    let mean_truth = mean(&truth);
    let relative = |s: &[f64; 3]| truth(s).powi(2) + DARK * mean_truth * mean_truth;
    let product = |s: &[f64; 3]| (s[0] - s[1]) * (s[0] - s[2]);
    let mean_image = mean(&|s| s[0]);
    let lit = mean_truth > 0.0;
    Score {
        rel_mse: lit.then(|| mean(&|s| product(s) / relative(s))),
        nrmse: lit.then(|| mean(&product).max(0.0).sqrt() / mean_truth),
        bias: lit.then(|| mean_image / mean_truth - 1.0),
        mean: mean_image,
        max_abs: samples.iter().map(|s| (s[0] - truth(s)).abs()).fold(0.0, f64::max),
        reference_noise: lit.then(|| mean(&|s| ((s[1] - s[2]) / 2.0).powi(2) / relative(s))),
    }
}
