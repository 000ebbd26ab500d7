//! The README's animation: hulls that are apart close and fall as one body; then the mesh bursts
//! into them.
//!
//! The first frame, which is all that a still shows, has the hulls apart. It is an animated PNG of
//! at most 256 colours, in which each frame holds only what changes. The same machine writes the
//! same bytes.

use std::collections::HashMap;
use std::f64::consts::PI;
use std::fs::File;
use std::io::BufWriter;
use std::path::Path;

use color_quant::NeuQuant;
use glam::DVec3;
use hullwright::{Control, Parameters, TriangleMesh, decompose, mass_properties};
use hullwright_formats::palette::{CLAY, Colour, colour};
use hullwright_formats::read_mesh;
use rapier3d::prelude::*;

use crate::render::{Layout, Panel, Part, Picture, render_with};
use crate::shapes::{bounds, middle};
use crate::terminal::{Failure, print};

/// Size of the picture, in pixels.
const SIZE: (usize, usize) = (560, 400);

/// Pictures in a second.
const RATE: u16 = 20;

/// Steps of physics between two pictures.
const STEPS: usize = 6;

/// Angles from which it is seen, in degrees.
const VIEW: (f64, f64) = (24.0, 17.0);

/// Seconds: hulls stay apart, close, and rest after the fall.
const STAYS: f64 = 0.8;
const CLOSES: f64 = 0.6;
const RESTS: f64 = 1.5;

/// Longest fall, in seconds.
const FALLS: f64 = 4.0;

/// Seconds: the mesh stands, its hulls stand, and they move apart.
const STANDS: f64 = 0.7;
const HULLS: f64 = 0.35;
const BURSTS: f64 = 0.7;

/// How far hulls move apart, as a share of their way from the middle.
const APART: f64 = 0.55;

/// How high the middle goes meanwhile, as a share of the mesh's diagonal, and how far it tips over.
const RISES: f64 = 0.45;
const TIPS: [f64; 2] = [0.22, -0.3];

/// The floor, in diagonals of the mesh: half its width and depth.
const FLOOR: [f64; 2] = [0.72, 0.5];
const FLOOR_COLOUR: Colour = [228, 229, 232];

/// How high the picture reaches above the floor, in diagonals.
const HEADROOM: f64 = 1.15;

/// Mass per cubed unit. Only how it falls is seen.
const DENSITY: f64 = 100.0;

/// One pixel of this many is looked at for the table of colours.
const SAMPLING: i32 = 10;

pub fn draw(output: &Path, mesh: &Path) -> Result<(), Failure> {
    let mesh = standing(read_mesh(mesh)?.mesh);
    let hulls = decompose(&mesh, &Parameters::default(), &Control::new())?.hulls;

    let coloured = |apart: f64| -> Vec<(TriangleMesh, Colour)> {
        let parts = hulls.iter().enumerate().map(|(index, hull)| {
            let way = middle(&hull.shape.points) * apart;
            let moved = hull.shape.points.iter().map(|&point| (DVec3::from(point) + way).into());
            let moved = moved.collect();
            (TriangleMesh::new(moved, hull.shape.triangles.clone()), colour(index))
        });
        parts.collect()
    };
    let raised = |height: f64, tip: f64| {
        let [x, z] = TIPS.map(|angle| (angle * tip) as f32);
        let turn = Rotation::from_rotation_x(x) * Rotation::from_rotation_z(z);
        Pose::from_parts(Vector::new(0.0, (RISES * height) as f32, 0.0), turn)
    };
    let mut moments = vec![(coloured(APART), raised(1.0, 0.0)); pictures(STAYS)];
    let closing = eased(CLOSES);
    moments.extend(closing.map(|part| (coloured(APART * (1.0 - part)), raised(1.0, part))));
    let start = raised(1.0, 1.0);
    let properties = mass_properties(&mesh, &hulls, DENSITY)?;
    let collider = hullwright_rapier::collider(&hulls, &properties, [1.0; 3]);
    let collider = collider.map_err(|error| error.to_string())?;
    let floor = bounds(&mesh.positions).0.y;
    let poses = fall(collider, start, floor as f32);
    moments.extend(poses.into_iter().map(|pose| (coloured(0.0), pose)));
    moments
        .extend(moments.last().map(|last| vec![last.clone(); pictures(RESTS)]).unwrap_or_default());
    moments.extend(vec![(vec![(mesh.clone(), CLAY)], Pose::IDENTITY); pictures(STANDS)]);
    moments.extend(vec![(coloured(0.0), Pose::IDENTITY); pictures(HULLS)]);
    moments.extend(eased(BURSTS).map(|part| (coloured(APART * part), raised(part, 0.0))));
    let pictures = moments
        .into_iter()
        .map(|(parts, pose)| picture(parts, &pose, floor))
        .collect::<Result<Vec<_>, _>>()?;
    write(output, &pictures)?;
    let (pictures, hulls) = (pictures.len(), hulls.len());
    print(&format!("wrote {}: {pictures} pictures, {hulls} hulls", output.display()))
}

/// The mesh with a diagonal of 1 and its middle at the origin.
fn standing(mut mesh: TriangleMesh) -> TriangleMesh {
    let centre = middle(&mesh.positions);
    let (low, high) = bounds(&mesh.positions);
    for point in &mut mesh.positions {
        *point = ((DVec3::from(*point) - centre) / low.distance(high)).into();
    }
    mesh
}

/// For each picture of so many seconds a share of the way, slow at both ends.
fn eased(seconds: f64) -> impl Iterator<Item = f64> {
    let count = pictures(seconds);
    (1..=count).map(move |index| 0.5 - 0.5 * (PI * index as f64 / count as f64).cos())
}

fn pictures(seconds: f64) -> usize {
    (seconds * f64::from(RATE)).round() as usize
}

/// The body's poses until it sleeps.
fn fall(collider: ColliderBuilder, start: Pose, floor: f32) -> Vec<Pose> {
    let mut world = PhysicsWorld::new();
    world.integration_parameters.dt = 1.0 / (f32::from(RATE) * STEPS as f32);
    let ground = ColliderBuilder::cuboid(20.0, 1.0, 20.0).friction(0.8);
    world.insert_collider(ground.translation(Vector::new(0.0, floor - 1.0, 0.0)), None);
    let dynamic = RigidBodyBuilder::dynamic().pose(start).angular_damping(0.4);
    let (body, _) = world.insert(dynamic, collider.friction(0.7).restitution(0.15));
    let mut poses = Vec::new();
    while poses.len() < pictures(FALLS) && !world.bodies[body].is_sleeping() {
        for _ in 0..STEPS {
            world.step();
        }
        poses.push(*world.bodies[body].position());
    }
    poses
}

fn picture(
    parts: Vec<(TriangleMesh, Colour)>,
    pose: &Pose,
    floor: f64,
) -> Result<Picture, hullwright::Error> {
    let place = |point: [f64; 3]| {
        let moved = *pose * Vector::from(point.map(|x| x as f32));
        moved.to_array().map(f64::from)
    };
    let mut panel = Panel::default();
    let [width, depth] = FLOOR;
    let corners = [[-width, -depth], [width, -depth], [width, depth], [-width, depth]];
    let ground =
        TriangleMesh::new(corners.map(|[x, z]| [x, floor, z]).to_vec(), vec![[0, 2, 1], [0, 3, 2]]);
    panel.parts.push(Part { mesh: ground, colour: FLOOR_COLOUR });
    // A triangle without area is not seen; it holds the picture's frame where it is.
    let above = vec![[0.0, floor + HEADROOM, 0.0]; 3];
    let above = TriangleMesh::new(above, vec![[0, 1, 2]]);
    panel.parts.push(Part { mesh: above, colour: FLOOR_COLOUR });
    panel.parts.extend(parts.into_iter().map(|(mut mesh, colour)| {
        mesh.positions.iter_mut().for_each(|point| *point = place(*point));
        Part { mesh, colour }
    }));
    let mut layout = Layout::default();
    (layout.view.azimuth, layout.view.elevation) = VIEW;
    render_with(&[panel], SIZE.0, SIZE.1, &layout)
}

/// Writes an animated PNG; each frame is the rectangle that differs from the one before.
fn write(path: &Path, pictures: &[Picture]) -> Result<(), Box<dyn std::error::Error>> {
    let pixels: Vec<u8> = pictures
        .iter()
        .flat_map(|picture| picture.pixels())
        .flat_map(|&[red, green, blue]| [red, green, blue, 255])
        .collect();
    let table = NeuQuant::new(SAMPLING, 256, &pixels);
    let mut known: HashMap<Colour, u8> = HashMap::new();
    let mut indexed = |picture: &Picture| -> Vec<u8> {
        let pixels = picture.pixels().iter();
        let index = |colour: &Colour| {
            let [red, green, blue] = *colour;
            *known.entry(*colour).or_insert_with(|| table.index_of(&[red, green, blue, 255]) as u8)
        };
        pixels.map(index).collect()
    };
    // A frame that shows nothing new lengthens the one before.
    let mut frames: Vec<(Vec<u8>, u16)> = Vec::new();
    for picture in pictures.iter().map(&mut indexed) {
        match frames.last_mut() {
            Some((last, count)) if *last == picture => *count += 1,
            _ => frames.push((picture, 1)),
        }
    }
    let (width, height) = SIZE;
    let mut encoder =
        png::Encoder::new(BufWriter::new(File::create(path)?), width as u32, height as u32);
    encoder.set_color(png::ColorType::Indexed);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_palette(table.color_map_rgb());
    encoder.set_compression(png::Compression::High);
    encoder.set_animated(frames.len() as u32, 0)?;
    let mut writer = encoder.write_header()?;
    let mut before: Option<&Vec<u8>> = None;
    for (frame, count) in &frames {
        let [left, top, right, bottom] = changed(before, frame);
        writer.set_frame_position(0, 0)?;
        writer.set_frame_dimension((right - left) as u32, (bottom - top) as u32)?;
        writer.set_frame_position(left as u32, top as u32)?;
        writer.set_frame_delay(*count, RATE)?;
        let rows = (top..bottom).flat_map(|row| &frame[row * width + left..row * width + right]);
        writer.write_image_data(&rows.copied().collect::<Vec<u8>>())?;
        before = Some(frame);
    }
    writer.finish()?;
    Ok(())
}

/// The smallest rectangle in which two frames differ: left, top, right, bottom. All of it without
/// one before.
fn changed(before: Option<&Vec<u8>>, frame: &[u8]) -> [usize; 4] {
    let (width, height) = SIZE;
    let Some(before) = before else { return [0, 0, width, height] };
    let differs = |index: &usize| before[*index] != frame[*index];
    let start = [width, height, 0, 0];
    (0..frame.len()).filter(differs).fold(start, |[left, top, right, bottom], index| {
        let (x, y) = (index % width, index / width);
        [left.min(x), top.min(y), right.max(x + 1), bottom.max(y + 1)]
    })
}
