//! The path-traced truth that lies beside a scene: `<scene>_<camera>_*.exr`.

use crate::error::Result;
use crate::image::Image;
use crate::metrics::{self, Score};
use crate::scene::Scene;
use std::path::{Path, PathBuf};

/// The halves of the truth and what was hit.
#[derive(Clone, Debug)]
pub struct Reference {
    /// First independent half.
    pub half_a: Image,
    /// Second independent half.
    pub half_b: Image,
    /// Where a surface was seen.
    pub hit: Image<bool>,
}

impl Reference {
    /// Reads the truth of a camera; `None` where none lies beside the scene.
    pub fn beside(scene: &Scene, camera: &str) -> Result<Option<Self>> {
        Self::read(&scene.directory, &scene.name, camera)
    }

    /// Reads `<name>_<camera>_indirect_hA.exr`, `_hB.exr` and `_depth.exr`.
    pub fn read(directory: &Path, name: &str, camera: &str) -> Result<Option<Self>> {
        let path = |kind| file(directory, name, camera, kind);
        if !path("indirect_hA").is_file() || !path("indirect_hB").is_file() || !path("depth").is_file() {
            return Ok(None);
        }
        Ok(Some(Self {
            half_a: Image::read_exr(&path("indirect_hA"))?,
            half_b: Image::read_exr(&path("indirect_hB"))?,
            hit: Image::read_exr(&path("depth"))?.map(|d| d[2] > 0.0),
        }))
    }

    /// The mean of the halves.
    pub fn indirect(&self) -> Image {
        let mean = |(a, b): (&[f32; 3], &[f32; 3])| std::array::from_fn(|i| (a[i] + b[i]) / 2.0);
        let pixels = self.half_a.pixels.iter().zip(&self.half_b.pixels).map(mean).collect();
        Image { width: self.half_a.width, height: self.half_a.height, pixels }
    }

    /// Width and height in pixels.
    pub fn size(&self) -> [u32; 2] {
        [self.half_a.width, self.half_a.height]
    }

    /// Scores an image of E_ind; `None` where the sizes differ.
    pub fn score(&self, image: &Image) -> Option<Score> {
        let same_size = self.size() == [image.width, image.height];
        if same_size { metrics::score(image, &self.half_a, &self.half_b, &self.hit) } else { None }
    }
}

/// `<directory>/<name>_<camera>_<kind>.exr`; kinds: indirect, indirect_hA, indirect_hB, direct, depth, normal, albedo.
pub fn file(directory: &Path, name: &str, camera: &str, kind: &str) -> PathBuf {
    directory.join(format!("{name}_{camera}_{kind}.exr"))
}
