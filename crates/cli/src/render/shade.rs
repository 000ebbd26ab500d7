//! Samples to pixels: soft light, shade in corners, quiet edges, anti-aliasing.

use hullwright_formats::palette::{Colour, encode, linear};

use super::camera::Projection;
use super::raster::{NOTHING, Samples, SeenTriangle};
use crate::Vector;

/// Samples per pixel along each axis.
pub(super) const SUPERSAMPLING: usize = 3;

/// What is behind everything: almost white, with a breath of blue.
pub(super) const BACKGROUND: Colour = [246, 247, 250];

/// Towards the light, in the camera's space: over the viewer's left shoulder.
const TOWARDS_LIGHT: Vector = Vector::new(-0.5, 0.85, 0.65);

/// Light on a surface that faces away from the light: nothing turns black.
const AMBIENT_LIGHT: f64 = 0.42;

/// What is added on a surface that faces the light; a little overexposed, which looks sunny.
const DIRECT_LIGHT: f64 = 0.78;

/// Reach of the shade in corners, in radii of the bounding sphere.
const OCCLUSION_RADIUS: f64 = 0.22;

/// Reach of the shade in corners on the raster is at most this many samples, so that a large
/// picture of a near object takes no longer than others.
const OCCLUSION_REACH: f64 = 160.0;

/// How strong the shade in corners is.
const OCCLUSION_STRENGTH: f64 = 0.85;

/// Surfaces that rise by less than this, in radii, cast no shade: facets stay clean.
const OCCLUSION_BIAS: f64 = 0.006;

/// Places that each sample probes for shade; with the samples of a pixel all turned differently
/// that makes 9 times as many.
const OCCLUSION_PROBES: usize = 5;

/// Turns of the probes' spiral.
const OCCLUSION_TURNS: f64 = 2.0;

/// Darkening where a part borders on another part or on nothing.
const OUTLINE: f64 = 0.42;

/// Darkening along a crease at a right angle or sharper.
const CREASE: f64 = 0.30;

/// Darkening along the edges of all triangles, where they are drawn.
const WIRE: f64 = 0.38;

/// Cosines of the angles between normals (6 and 50 degrees) from which a crease begins to show
/// and at which it is drawn in full.
const CREASE_COSINES: (f64, f64) = (0.9945, 0.643);

/// A neighbour that lies behind the surface's plane by this many radii is not the same surface.
const STEP: f64 = 0.03;

/// A panel's triangles, ready to be shaded.
pub(super) struct Shader<'a> {
    samples: &'a Samples,
    triangles: &'a [SeenTriangle],
    projection: &'a Projection,
    /// Linear light of each part.
    colours: Vec<[f64; 3]>,
    background: [f64; 3],
    towards_light: Vector,
    probes: Vec<[[f64; 2]; OCCLUSION_PROBES]>,
    /// Whether the edges of all triangles are drawn.
    pub wires: bool,
}

impl<'a> Shader<'a> {
    pub(super) fn new(
        samples: &'a Samples,
        triangles: &'a [SeenTriangle],
        projection: &'a Projection,
        colours: impl Iterator<Item = Colour>,
    ) -> Self {
        let light = |colour: Colour| linear(colour).map(f64::from);
        Self {
            samples,
            triangles,
            projection,
            colours: colours.map(light).collect(),
            background: light(BACKGROUND),
            towards_light: TOWARDS_LIGHT.normalize_or_zero(),
            probes: probes(),
            wires: false,
        }
    }

    /// The colour of a pixel: the mean light of its samples.
    pub(super) fn pixel(&self, column: usize, row: usize) -> Colour {
        let mut sum = [0.0; 3];
        for y in row * SUPERSAMPLING..(row + 1) * SUPERSAMPLING {
            for x in column * SUPERSAMPLING..(column + 1) * SUPERSAMPLING {
                let light = self.sample(x, y);
                for channel in 0..3 {
                    sum[channel] += light[channel];
                }
            }
        }
        let count = (SUPERSAMPLING * SUPERSAMPLING) as f64;
        sum.map(|light| encode(light / count))
    }

    /// The triangle seen at a sample, and the point of it in the camera's space.
    fn look(&self, x: usize, y: usize) -> Option<(&SeenTriangle, Vector)> {
        let index = y * self.samples.width + x;
        let triangle = *self.samples.triangle.get(index)?;
        if triangle == NOTHING {
            return None;
        }
        let inverse_depth = f64::from(*self.samples.inverse_depth.get(index)?);
        let (x, y) = (x as f64 + 0.5, y as f64 + 0.5);
        let point = self.projection.unproject(x, y, inverse_depth);
        Some((self.triangles.get(triangle as usize)?, point))
    }

    fn sample(&self, x: usize, y: usize) -> [f64; 3] {
        let Some((triangle, point)) = self.look(x, y) else {
            return self.background;
        };
        let wrapped = 0.5 + 0.5 * triangle.normal.dot(self.towards_light);
        let light = (AMBIENT_LIGHT + DIRECT_LIGHT * wrapped * wrapped)
            * (1.0 - self.occlusion(x, y, triangle.normal, point))
            * (1.0 - self.edge(x, y, triangle, point));
        let colour = self.colours.get(triangle.part as usize);
        colour.map_or(self.background, |colour| colour.map(|channel| channel * light))
    }

    /// Share of the light that nearby surfaces take away. After McGuire et al., The Alchemy
    /// Screen-Space Ambient Obscurance Algorithm (HPG 2011), section 3.
    fn occlusion(&self, x: usize, y: usize, normal: Vector, point: Vector) -> f64 {
        let depth = self.projection.viewer()[2] - point[2];
        let reach = OCCLUSION_RADIUS * self.projection.raster_length(1.0 / depth);
        let reach = reach.min(OCCLUSION_REACH);
        let turn = (y % SUPERSAMPLING) * SUPERSAMPLING + x % SUPERSAMPLING;
        let Some(probes) = self.probes.get(turn) else {
            return 0.0;
        };
        let mut shade = 0.0;
        for probe in probes {
            let probe_x = x as f64 + 0.5 + reach * probe[0];
            let probe_y = y as f64 + 0.5 + reach * probe[1];
            let inside = probe_x >= 0.0
                && probe_y >= 0.0
                && probe_x < self.samples.width as f64
                && probe_y < self.samples.height as f64;
            if !inside {
                continue;
            }
            let Some((_, other)) = self.look(probe_x as usize, probe_y as usize) else {
                continue;
            };
            let towards = other - point;
            let squared = towards.length_squared();
            if squared > OCCLUSION_RADIUS * OCCLUSION_RADIUS {
                continue;
            }
            let rise = (towards.dot(normal) - OCCLUSION_BIAS).max(0.0);
            shade += rise / (squared + OCCLUSION_BIAS * OCCLUSION_BIAS).max(f64::MIN_POSITIVE);
        }
        // The sum has the unit of one over a length: the radius makes it a number.
        let mean = shade * OCCLUSION_RADIUS / OCCLUSION_PROBES as f64;
        1.0 - 1.0 / (1.0 + OCCLUSION_STRENGTH * mean)
    }

    /// Darkening by the edges next to a sample.
    fn edge(&self, x: usize, y: usize, triangle: &SeenTriangle, point: Vector) -> f64 {
        let index = y * self.samples.width + x;
        let here = self.samples.triangle[index];
        let neighbours = [
            (x > 0).then(|| (x - 1, y)),
            (x + 1 < self.samples.width).then_some((x + 1, y)),
            (y > 0).then(|| (x, y - 1)),
            (y + 1 < self.samples.height).then_some((x, y + 1)),
        ];
        let mut darkest: f64 = 0.0;
        for (x, y) in neighbours.into_iter().flatten() {
            if self.samples.triangle[y * self.samples.width + x] == here {
                continue;
            }
            let darkening = match self.look(x, y) {
                None => OUTLINE,
                Some((other, _)) if other.part != triangle.part => OUTLINE,
                Some((other, other_point)) => {
                    let behind = -(other_point - point).dot(triangle.normal);
                    if behind > STEP && other_point[2] < point[2] {
                        OUTLINE
                    } else {
                        let wire = if self.wires { WIRE } else { 0.0 };
                        wire.max(CREASE * crease(triangle.normal.dot(other.normal)))
                    }
                }
            };
            darkest = darkest.max(darkening);
        }
        darkest
    }
}

/// How much of a crease shows, from 0 to 1, by the cosine of the angle between the normals.
fn crease(cosine: f64) -> f64 {
    let (begin, full) = CREASE_COSINES;
    let share = ((begin - cosine) / (begin - full)).clamp(0.0, 1.0);
    share * share * (3.0 - 2.0 * share)
}

/// For each sample of a pixel places in the unit disc, on spirals that are turned evenly.
fn probes() -> Vec<[[f64; 2]; OCCLUSION_PROBES]> {
    let patterns = SUPERSAMPLING * SUPERSAMPLING;
    let pattern = |turn: usize| {
        let turn = turn as f64 / patterns as f64;
        std::array::from_fn(|probe| {
            let share = (probe as f64 + 0.2 + 0.8 * turn) / OCCLUSION_PROBES as f64;
            let angle = std::f64::consts::TAU * (OCCLUSION_TURNS * share + turn);
            [share * angle.cos(), share * angle.sin()]
        })
    };
    (0..patterns).map(pattern).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_crease_shows_the_more_the_sharper_it_is() {
        let degrees = [0.0, 5.0, 15.0, 30.0, 60.0, 90.0, 180.0_f64];
        let shown = degrees.map(|angle| crease(angle.to_radians().cos()));
        assert!(shown.windows(2).all(|pair| pair[0] <= pair[1]));
        assert_eq!((shown[0], shown[1], shown[6]), (0.0, 0.0, 1.0));
    }

    #[test]
    fn probes_stay_in_the_unit_disc_and_differ() {
        let mut places: Vec<[f64; 2]> = probes().into_iter().flatten().collect();
        assert!(places.iter().all(|[x, y]| x * x + y * y <= 1.0 + 1e-12));
        places.sort_by(|a, b| a.partial_cmp(b).unwrap());
        places.dedup();
        assert_eq!(places.len(), SUPERSAMPLING * SUPERSAMPLING * OCCLUSION_PROBES);
    }
}
