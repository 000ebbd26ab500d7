//! Web workers, in which a browser's jobs are decomposed: the module of the npm package, and a worker for each
//! decomposition at once. A frame only asks whether they have answered.
//!
//! JavaScript's values stay on their thread, so what is here belongs to the thread of the game, and a [`Call`] names
//! what it waits for by a number.

use std::cell::RefCell;
use std::collections::HashMap;

use js_sys::{
    Array, Float32Array, Function, Object, Reflect, Uint8Array, Uint32Array, WebAssembly,
};
use wasm_bindgen::prelude::{Closure, JsCast, JsValue};
use web_sys::{MessageEvent, Response};

use super::request::MeshData;
use crate::hulls_format::HullsFile;

/// The files of the npm package that a game ships.
const FILES: [&str; 2] = ["worker-core.js", "hullwright-core.wasm"];

/// A decomposition in a worker. Dropped before it is done, it ends the worker.
#[derive(Debug)]
pub(super) struct Call(u64);

/// What has become of a call.
pub(super) enum Answer {
    Pending,
    Hulls(Box<HullsFile>),
    /// The worker's memory is not enough, or its code panicked.
    Trapped,
    /// The method gave an error, or there are no workers: it is to be done here.
    Refused,
}

/// What is sent to a worker.
struct Request {
    mesh: Object,
    buffers: Array,
    parameters: String,
    progress: Listener,
}

/// Hears which share of the work is done.
type Listener = Box<dyn Fn(f32)>;

/// One worker, and the call that it works on.
struct Seat {
    worker: web_sys::Worker,
    call: Option<u64>,
    has_module: bool,
    // They live as long as the worker may call them.
    _listeners: [Closure<dyn FnMut(MessageEvent)>; 2],
}

#[derive(Default)]
enum Module {
    #[default]
    NotAsked,
    Loading,
    Ready(WebAssembly::Module),
    Missing,
}

#[derive(Default)]
struct Workers {
    folder: String,
    module: Module,
    seats: Vec<Seat>,
    calls: u64,
    waiting: Vec<(u64, Request)>,
    progress: HashMap<u64, Listener>,
    answers: HashMap<u64, Answer>,
}

thread_local! {
    static WORKERS: RefCell<Workers> = RefCell::default();
}

/// Processors, as the browser says.
pub(super) fn processors() -> usize {
    web_sys::window().map_or(1, |window| window.navigator().hardware_concurrency() as usize)
}

impl Call {
    /// Asks for hulls of a mesh, with mass properties at a density of 1, from a worker whose files are in `folder`.
    /// Nothing where there are no workers.
    pub(super) fn start(
        folder: &str,
        data: &MeshData,
        parameters: String,
        progress: impl Fn(f32) + 'static,
    ) -> Option<Self> {
        let positions = Float32Array::from(data.positions.as_flattened());
        let indices = Uint32Array::from(data.triangles.as_flattened());
        let buffers = Array::of2(&positions.buffer(), &indices.buffer());
        let sidedness = Uint8Array::new_with_length(0);
        let mesh = object(&[
            ("positions", positions.into()),
            ("indices", indices.into()),
            ("doubleSided", sidedness.into()),
        ]);
        let request = Request { mesh, buffers, parameters, progress: Box::new(progress) };
        WORKERS.with_borrow_mut(|workers| {
            if matches!(workers.module, Module::Missing) {
                return None;
            }
            workers.calls += 1;
            workers.waiting.push((workers.calls, request));
            if matches!(workers.module, Module::NotAsked) {
                workers.folder = folder.trim_end_matches('/').to_owned();
                workers.load();
            }
            Some(Self(workers.calls))
        })
    }

    pub(super) fn answer(&self) -> Answer {
        WORKERS.with_borrow_mut(|workers| {
            workers.send_waiting();
            if matches!(workers.module, Module::Missing) {
                return Answer::Refused;
            }
            workers.answers.remove(&self.0).unwrap_or(Answer::Pending)
        })
    }
}

impl Drop for Call {
    fn drop(&mut self) {
        WORKERS.with_borrow_mut(|workers| {
            workers.waiting.retain(|(call, _)| *call != self.0);
            workers.answers.remove(&self.0);
            workers.progress.remove(&self.0);
            workers.end_worker_of(self.0);
        });
    }
}

impl Workers {
    /// Fetches and compiles the module.
    fn load(&mut self) {
        self.module = Module::Loading;
        let Some(window) = web_sys::window() else { return self.give_up("there is no window") };
        let address = self.address(FILES[1]);
        let failed = Closure::once_into_js(move |error: JsValue| {
            WORKERS.with_borrow_mut(|workers| workers.give_up(&text(&error)));
        });
        let compiled = Closure::once_into_js(|module: JsValue| {
            WORKERS.with_borrow_mut(|workers| match module.dyn_into() {
                Ok(module) => workers.module = Module::Ready(module),
                Err(_) => workers.give_up("what was fetched is no module"),
            });
        });
        let fetched = Closure::once_into_js(|response: JsValue| -> Result<JsValue, JsValue> {
            let response: Response = response.dyn_into()?;
            match response.ok() {
                true => Ok(response.array_buffer()?.into()),
                false => Err(format!("{}: {}", response.url(), response.status_text()).into()),
            }
        });
        // By bytes, since not every host says that it is WebAssembly.
        let compile = Closure::once_into_js(|bytes: JsValue| -> JsValue {
            WebAssembly::compile(&bytes).into()
        });
        let mut step: JsValue = window.fetch_with_str(&address).into();
        for function in [fetched, compile, compiled] {
            step = match then(&step, &[function]) {
                Ok(next) => next,
                Err(error) => return self.give_up(&text(&error)),
            };
        }
        if let Err(error) = then(&step, &[JsValue::UNDEFINED, failed]) {
            self.give_up(&text(&error));
        }
    }

    fn address(&self, file: &str) -> String {
        format!("{}/{file}", self.folder)
    }

    /// From now on all is done in slices. Said once.
    fn give_up(&mut self, reason: &str) {
        if !matches!(self.module, Module::Missing) {
            let [script, module] = FILES.map(|file| self.address(file));
            log::warn!(
                "no workers for convex decompositions, which are made in slices: {reason}. A game \
                 ships {script} and {module} of the npm package `hullwright`"
            );
        }
        self.module = Module::Missing;
        self.seats.drain(..).for_each(|seat| seat.worker.terminate());
        self.waiting.clear();
    }

    /// Sends what waits to workers that are free, or new. There are never more calls than workers may be.
    fn send_waiting(&mut self) {
        let Module::Ready(module) = &self.module else { return };
        let module = module.clone();
        for (call, request) in std::mem::take(&mut self.waiting) {
            if let Err(error) = self.send(&module, call, &request) {
                return self.give_up(&text(&error));
            }
            self.progress.insert(call, request.progress);
        }
    }

    fn send(
        &mut self,
        module: &WebAssembly::Module,
        call: u64,
        request: &Request,
    ) -> Result<(), JsValue> {
        let free = self.seats.iter().position(|seat| seat.call.is_none());
        let index = match free {
            Some(index) => index,
            None => {
                self.seats.push(Seat::new(&self.address(FILES[0]))?);
                self.seats.len() - 1
            }
        };
        let Some(seat) = self.seats.get_mut(index) else { return Ok(()) };
        let arguments = Array::of2(&request.mesh, &request.parameters.as_str().into());
        let mut message = vec![
            ("call", "decompose".into()),
            ("args", arguments.into()),
            ("isHeard", JsValue::TRUE),
        ];
        if !seat.has_module {
            message.push(("module", module.clone().into()));
        }
        seat.worker.post_message_with_transfer(&object(&message), &request.buffers)?;
        (seat.has_module, seat.call) = (true, Some(call));
        Ok(())
    }

    /// Takes a message of a worker. An answer frees it.
    fn hear(&mut self, worker: &JsValue, message: &JsValue) {
        let is_from = |seat: &&Seat| *AsRef::<JsValue>::as_ref(&seat.worker) == *worker;
        let Some(call) = self.seats.iter().find(is_from).and_then(|seat| seat.call) else { return };
        if let Some(progress) = get(message, "progress") {
            let fraction = get(&progress, "fraction").and_then(|fraction| fraction.as_f64());
            if let (Some(listener), Some(fraction)) = (self.progress.get(&call), fraction) {
                listener(fraction as f32);
            }
            return;
        }
        self.progress.remove(&call);
        let file = get(message, "value").and_then(|value| get(&value, "hullsFile"));
        let answer = match file.map(|file| HullsFile::from_bytes(&Uint8Array::new(&file).to_vec()))
        {
            Some(Ok(file)) => Answer::Hulls(Box::new(file)),
            // Another version of the package.
            Some(Err(_)) => Answer::Refused,
            None => {
                let code = get(message, "error").and_then(|error| get(&error, "code"));
                match code.and_then(|code| code.as_string()).as_deref() {
                    Some("trap") => Answer::Trapped,
                    _ => Answer::Refused,
                }
            }
        };
        if matches!(answer, Answer::Trapped) {
            self.end_worker_of(call);
        }
        let seat = self.seats.iter_mut().find(|seat| seat.call == Some(call));
        if let Some(seat) = seat {
            seat.call = None;
        }
        self.answers.insert(call, answer);
    }

    fn end_worker_of(&mut self, call: u64) {
        for seat in self.seats.extract_if(.., |seat| seat.call == Some(call)) {
            seat.worker.terminate();
        }
    }
}

impl Seat {
    fn new(script: &str) -> Result<Self, JsValue> {
        let worker = web_sys::Worker::new(script)?;
        let of: JsValue = worker.clone().into();
        let on_message = Closure::new(move |event: MessageEvent| {
            WORKERS.with_borrow_mut(|workers| workers.hear(&of, &event.data()));
        });
        // The script is not there, or is none.
        let on_error = Closure::new(|event: MessageEvent| {
            let reason = get(&event, "message").and_then(|message| message.as_string());
            let reason = reason.unwrap_or_else(|| "the worker could not be started".into());
            WORKERS.with_borrow_mut(|workers| workers.give_up(&reason));
        });
        let function = |closure: &Closure<dyn FnMut(MessageEvent)>| -> Function {
            closure.as_ref().unchecked_ref::<Function>().clone()
        };
        worker.set_onmessage(Some(&function(&on_message)));
        worker.set_onerror(Some(&function(&on_error)));
        let _listeners = [on_message, on_error];
        Ok(Self { worker, call: None, has_module: false, _listeners })
    }
}

/// Calls `then` of a promise.
fn then(promise: &JsValue, functions: &[JsValue]) -> Result<JsValue, JsValue> {
    let method: Function = Reflect::get(promise, &"then".into())?.dyn_into()?;
    method.apply(promise, &functions.iter().collect::<Array>())
}

fn object(fields: &[(&str, JsValue)]) -> Object {
    let pairs = fields.iter().map(|(name, value)| Array::of2(&(*name).into(), value));
    Object::from_entries(&pairs.collect::<Array>()).unwrap_or_default()
}

/// A field that is there.
fn get(of: &JsValue, name: &str) -> Option<JsValue> {
    Reflect::get(of, &name.into()).ok().filter(|value| !value.is_undefined())
}

fn text(error: &JsValue) -> String {
    let message = get(error, "message").and_then(|message| message.as_string());
    message.or_else(|| error.as_string()).unwrap_or_else(|| "an unknown error".into())
}
