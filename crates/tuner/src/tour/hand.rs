//! A hand on mouse and keyboard: clicks and keys as the window would report them.

use std::collections::VecDeque;
use std::path::PathBuf;

use bevy::ecs::system::SystemParam;
use bevy::input::ButtonState;
use bevy::input::keyboard::{Key, KeyboardInput, NativeKeyCode};
use bevy::input::mouse::{MouseButtonInput, MouseMotion, MouseScrollUnit, MouseWheel};
use bevy::input::touch::TouchPhase;
use bevy::prelude::*;
use bevy::window::{CursorMoved, FileDragAndDrop, PrimaryWindow, WindowEvent};
use bevy_egui::egui;

use crate::ui::Controls;

/// Width of the number beside a slider, in pixels.
const NUMBER: f32 = 65.0;

/// Steps of a drag.
const DRAG_STEPS: usize = 8;

/// What a person does.
#[derive(Debug, Clone, PartialEq)]
pub enum Deed {
    /// Clicks a control.
    Click(&'static str),
    /// Clicks a slider's rail at this share of its width.
    Slide(&'static str, f32),
    /// Presses a key.
    Key(&'static str),
    /// Writes.
    Type(String),
    /// Drops a file on the window.
    DropFile(PathBuf),
    /// Drags in the picture, by pixels to the right and down.
    Drag(f32, f32),
    /// Turns the wheel by clicks.
    Wheel(f32),
    /// Moves the pointer to these shares of the window's width and height.
    Point(f32, f32),
    /// Waits for frames.
    Wait(usize),
}

/// What the window reports in one frame.
#[derive(Debug, Clone)]
enum Report {
    Nothing,
    /// The pointer over a control, at this share of its width, or of a rail's.
    Over(&'static str, f32, bool),
    At(Vec2),
    Moved(Vec2),
    Button(ButtonState),
    Key(String, ButtonState),
    Dropped(PathBuf),
    Wheel(f32),
}

/// Reports to come, one each frame.
#[derive(Default)]
pub struct Hand {
    reports: VecDeque<Report>,
    at: Vec2,
}

/// Where reports go.
#[derive(SystemParam)]
pub struct Devices<'w, 's> {
    windows: Query<'w, 's, (Entity, &'static Window), With<PrimaryWindow>>,
    controls: Res<'w, Controls>,
    events: MessageWriter<'w, WindowEvent>,
    buttons: MessageWriter<'w, MouseButtonInput>,
    motions: MessageWriter<'w, MouseMotion>,
    wheels: MessageWriter<'w, MouseWheel>,
    keys: MessageWriter<'w, KeyboardInput>,
    files: MessageWriter<'w, FileDragAndDrop>,
}

impl Hand {
    /// Whether all is done.
    pub fn is_idle(&self) -> bool {
        self.reports.is_empty()
    }

    /// Does something after all else.
    pub fn take_on(&mut self, deed: &Deed) {
        use ButtonState::{Pressed, Released};
        let click =
            |over: Report| [over.clone(), over, Report::Button(Pressed), Report::Button(Released)];
        match deed {
            Deed::Click(name) => self.reports.extend(click(Report::Over(name, 0.5, false))),
            Deed::Slide(name, share) => {
                self.reports.extend(click(Report::Over(name, *share, true)));
            }
            Deed::Key(key) => self.press(key),
            Deed::Type(text) => {
                for letter in text.chars() {
                    self.press(&letter.to_string());
                }
            }
            Deed::DropFile(path) => self.reports.push_back(Report::Dropped(path.clone())),
            Deed::Wheel(clicks) => self.reports.push_back(Report::Wheel(*clicks)),
            Deed::Point(x, y) => self.reports.push_back(Report::At(Vec2::new(*x, *y))),
            Deed::Wait(frames) => self.reports.extend(vec![Report::Nothing; *frames]),
            Deed::Drag(x, y) => {
                let way = Vec2::new(*x, *y) / DRAG_STEPS as f32;
                // The lower right of the picture has nothing over it.
                let start = Report::At(Vec2::new(0.8, 0.75));
                self.reports.extend([start.clone(), start, Report::Button(Pressed)]);
                self.reports.extend(vec![Report::Moved(way); DRAG_STEPS]);
                self.reports.push_back(Report::Button(Released));
            }
        }
        // What a click changes is drawn in the next frame.
        self.reports.extend([Report::Nothing, Report::Nothing]);
    }

    fn press(&mut self, key: &str) {
        for state in [ButtonState::Pressed, ButtonState::Released] {
            self.reports.push_back(Report::Key(key.to_owned(), state));
        }
    }

    /// Reports what comes next. An error if a control is not there.
    pub fn go_on(&mut self, devices: &mut Devices) -> Result<(), String> {
        let Some(report) = self.reports.pop_front() else { return Ok(()) };
        let Ok((window, size)) = devices.windows.single() else { return Ok(()) };
        match report {
            Report::Nothing => {}
            Report::Over(name, share, is_rail) => {
                let Some(place) = devices.controls.get(name) else {
                    return Err(format!("there is no control called {name}"));
                };
                self.move_to(devices, window, point(place, share, is_rail));
            }
            Report::At(share) => self.move_to(devices, window, share * size.size()),
            Report::Moved(way) => self.move_to(devices, window, self.at + way),
            Report::Button(state) => {
                let click = MouseButtonInput { button: MouseButton::Left, state, window };
                devices.events.write(WindowEvent::MouseButtonInput(click));
                devices.buttons.write(click);
            }
            Report::Key(key, state) => {
                devices.keys.write(KeyboardInput {
                    key_code: KeyCode::Unidentified(NativeKeyCode::Unidentified),
                    logical_key: Key::Character(key.as_str().into()),
                    state,
                    text: None,
                    repeat: false,
                    window,
                });
            }
            Report::Dropped(path_buf) => {
                devices.files.write(FileDragAndDrop::DroppedFile { window, path_buf });
            }
            Report::Wheel(y) => {
                self.move_to(devices, window, Vec2::new(0.8, 0.75) * size.size());
                let unit = MouseScrollUnit::Line;
                devices.wheels.write(MouseWheel {
                    unit,
                    x: 0.0,
                    y,
                    window,
                    phase: TouchPhase::Moved,
                });
            }
        }
        Ok(())
    }

    fn move_to(&mut self, devices: &mut Devices, window: Entity, position: Vec2) {
        let delta = position - self.at;
        let moved = CursorMoved { window, position, delta: Some(delta) };
        devices.events.write(WindowEvent::CursorMoved(moved));
        devices.motions.write(MouseMotion { delta });
        self.at = position;
    }
}

fn point(place: egui::Rect, share: f32, is_rail: bool) -> Vec2 {
    let width = if is_rail { place.width() - NUMBER } else { place.width() };
    Vec2::new(place.left() + share * width, place.center().y)
}
