//! Web workers, in which a browser's jobs are decomposed or simplified: the module of the npm
//! package, and a worker for each mesh at once. A frame only asks whether they have answered.
//!
//! JavaScript's values stay on their thread, so what is here belongs to the thread of the game, and
//! a [`Call`] names what it waits for by a number.

use std::cell::RefCell;
use std::collections::HashMap;
use std::time::Duration;

use bevy::platform::time::Instant;
use hullwright::ALGORITHM_VERSION;
use hullwright::hulls_format::HullsFile;
use js_sys::{
    Array, Float32Array, Float64Array, Function, Object, Reflect, Uint8Array, Uint32Array,
    WebAssembly,
};
use wasm_bindgen::prelude::{Closure, JsCast, JsValue};
use web_sys::{MessageEvent, Response};

use crate::jobs::level::FewTriangles;
use crate::jobs::request::MeshData;

/// The files of the npm package that a game ships.
const FILES: [&str; 2] = ["worker-core.js", "hullwright-core.wasm"];

/// So long a module may take to come, and a new worker to send its first sign of progress, which it
/// sends before any work. Longer than a slow network takes for a megabyte; entities wait meanwhile.
const LOAD_LIMIT: Duration = Duration::from_secs(30);

/// A worker without a call is ended after once or twice this, since its memory never shrinks.
/// Longer than pauses in a level that loads; a fresh worker takes some 10 ms of its own thread.
const IDLE: Duration = Duration::from_secs(5);

/// A mesh in a worker. Dropped before it is done, it ends the worker.
#[derive(Debug)]
pub(in crate::jobs) struct Call(u64);

/// What has become of a call.
pub(super) enum Answer {
    Pending,
    Hulls(Box<HullsFile>),
    Surface(FewTriangles),
    /// The worker's memory is not enough, or its code panicked.
    Trapped,
    /// There was an error, or there is no worker for it: it is to be done here.
    Refused,
}

/// What is sent to a worker.
struct Request {
    /// What is called of the package.
    function: &'static str,
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
    /// When it was started, or its last call ended.
    since: Instant,
    /// Whether script and module have run.
    has_answered: bool,
}

#[derive(Default)]
enum Module {
    #[default]
    NotAsked,
    Loading(Instant),
    Ready(WebAssembly::Module),
    Missing,
}

#[derive(Default)]
struct Workers {
    folder: String,
    module: Module,
    /// Whether any worker has ever run.
    has_answered: bool,
    seats: Vec<Seat>,
    calls: u64,
    waiting: Vec<(u64, Request)>,
    progress: HashMap<u64, Listener>,
    answers: HashMap<u64, Answer>,
}

thread_local! {
    static WORKERS: RefCell<Workers> = RefCell::default();
    // For all workers, and never dropped: an event may come after its worker has been ended.
    static ON_MESSAGE: Function =
        listener(|workers, worker, event| workers.hear(worker, &event.data()));
    static ON_ERROR: Function = listener(|workers, worker, event| {
        let reason = get(event, "message").and_then(|message| message.as_string());
        let reason = reason.unwrap_or_else(|| match event.type_().as_str() {
            "messageerror" => "the worker sent what can't be read".into(),
            _ => "the worker could not be started".into(),
        });
        // It is logged, and not an error of the page.
        event.prevent_default();
        workers.lose(worker, &reason);
    });
}

/// Processors, as the browser says.
pub(in crate::jobs) fn processors() -> usize {
    web_sys::window().map_or(1, |window| window.navigator().hardware_concurrency() as usize)
}

impl Call {
    /// Asks a worker, whose files are in `folder`, for what a function of the package makes of a
    /// mesh: hulls, with mass properties at a density of 1, or few triangles. Nothing where there
    /// are no workers.
    pub(super) fn start(
        folder: &str,
        function: &'static str,
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
        let progress = Box::new(progress);
        let request = Request { function, mesh, buffers, parameters, progress };
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
            workers.limit_loading();
            let answer = workers.answers.remove(&self.0);
            answer.unwrap_or(match workers.module {
                Module::Missing => Answer::Refused,
                _ => Answer::Pending,
            })
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
        self.module = Module::Loading(Instant::now());
        let Some(window) = web_sys::window() else { return self.give_up("there is no window") };
        let address = self.address(FILES[1]);
        let failed = Closure::once_into_js(move |error: JsValue| {
            WORKERS.with_borrow_mut(|workers| workers.give_up(&text(&error)));
        });
        let compiled = Closure::once_into_js(|module: JsValue| {
            WORKERS.with_borrow_mut(|workers| match (&workers.module, module.dyn_into()) {
                (Module::Loading(_), Ok(module)) => workers.module = Module::Ready(module),
                // Too late.
                (_, Ok(_)) => {}
                (_, Err(_)) => workers.give_up("what was fetched is no module"),
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
                "no workers: meshes are decomposed in slices, and simplified at once: {reason}. A game \
                 ships {script} and {module} of the npm package `hullwright`"
            );
        }
        self.module = Module::Missing;
        self.seats.clear();
        self.waiting.clear();
        self.progress.clear();
    }

    /// A worker is of no more use. Where none has ever run, none will.
    fn lose(&mut self, worker: &JsValue, reason: &str) {
        let Some(index) = self.seats.iter().position(|seat| seat.is(worker)) else { return };
        if !self.has_answered {
            return self.give_up(reason);
        }
        let Seat { call, .. } = self.seats.remove(index);
        log::warn!(
            "a mesh is taken on the game's own thread, since its worker has ended: {reason}"
        );
        if let Some(call) = call {
            self.progress.remove(&call);
            self.answers.insert(call, Answer::Refused);
        }
    }

    /// A fetch, or a worker's script, may never come, without an error.
    fn limit_loading(&mut self) {
        let is_late = |since: Instant| since.elapsed() > LOAD_LIMIT;
        if matches!(self.module, Module::Loading(since) if is_late(since)) {
            self.give_up("the module does not load");
        }
        let is_silent = |seat: &&Seat| !seat.has_answered && is_late(seat.since);
        if let Some(worker) = self.seats.iter().find(is_silent).map(|seat| seat.worker.clone()) {
            self.lose(&worker, "the script does not load");
        }
    }

    /// Sends what waits to workers that are free, or new. There are never more calls than workers
    /// may be.
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
            ("call", request.function.into()),
            ("args", arguments.into()),
            ("isHeard", JsValue::TRUE),
        ];
        if !seat.has_answered {
            message.push(("module", module.clone().into()));
        }
        seat.worker.post_message_with_transfer(&object(&message), &request.buffers)?;
        seat.call = Some(call);
        Ok(())
    }

    /// Takes a message of a worker. An answer frees it.
    fn hear(&mut self, worker: &JsValue, message: &JsValue) {
        let Some(seat) = self.seats.iter_mut().find(|seat| seat.is(worker)) else { return };
        let Some(call) = seat.call else { return };
        let error = get(message, "error").unwrap_or_default();
        let code = get(&error, "code").and_then(|code| code.as_string());
        // The module can't be instantiated: it is not of the script's build, or memory is short.
        if code.as_deref() == Some("worker") {
            return self.lose(worker, &text(&error));
        }
        (seat.has_answered, self.has_answered) = (true, true);
        if let Some(progress) = get(message, "progress") {
            let fraction = get(&progress, "fraction").and_then(|fraction| fraction.as_f64());
            if let (Some(listener), Some(fraction)) = (self.progress.get(&call), fraction) {
                listener(fraction as f32);
            }
            return;
        }
        let answer = match get(message, "value").map(|value| made(&value)) {
            Some(Some(answer)) => answer,
            Some(None) => return self.give_up("the module is of another version"),
            None if code.as_deref() == Some("trap") => Answer::Trapped,
            None => Answer::Refused,
        };
        match answer {
            Answer::Trapped => self.end_worker_of(call),
            _ => (seat.call, seat.since) = (None, Instant::now()),
        }
        self.progress.remove(&call);
        self.answers.insert(call, answer);
        end_idle_later();
    }

    fn end_worker_of(&mut self, call: u64) {
        self.seats.retain(|seat| seat.call != Some(call));
    }
}

impl Seat {
    fn new(script: &str) -> Result<Self, JsValue> {
        let worker = web_sys::Worker::new(script)?;
        ON_MESSAGE.with(|function| worker.set_onmessage(Some(function)));
        // Chromium's workers have the event `messageerror`, but no `onmessageerror`.
        for event in ["error", "messageerror"] {
            ON_ERROR.with(|function| worker.add_event_listener_with_callback(event, function))?;
        }
        Ok(Self { worker, call: None, since: Instant::now(), has_answered: false })
    }

    fn is(&self, worker: &JsValue) -> bool {
        *AsRef::<JsValue>::as_ref(&self.worker) == *worker
    }
}

impl Drop for Seat {
    fn drop(&mut self) {
        self.worker.terminate();
    }
}

/// What a worker has made; nothing if its module is of another version.
fn made(value: &JsValue) -> Option<Answer> {
    if let Some(file) = get(value, "hullsFile") {
        let file = HullsFile::from_bytes(&Uint8Array::new(&file).to_vec()).ok()?;
        return file.is_current().then(|| Answer::Hulls(Box::new(file)));
    }
    let version = get(&get(value, "report")?, "algorithmVersion")?.as_f64()?;
    if version != f64::from(ALGORITHM_VERSION) {
        return None;
    }
    let numbers = |name| Some(Uint32Array::new(&get(value, name)?).to_vec());
    let positions = Float64Array::new(&get(value, "positions")?).to_vec();
    let triangles = numbers("indices")?.as_chunks().0.to_vec();
    let few = FewTriangles::new(positions.as_chunks().0, triangles, numbers("sources")?);
    Some(Answer::Surface(few))
}

/// Takes events of any worker.
fn listener(take: fn(&mut Workers, &JsValue, &MessageEvent)) -> Function {
    let closure = Closure::<dyn Fn(MessageEvent)>::new(move |event: MessageEvent| {
        let worker = get(&event, "currentTarget").unwrap_or_default();
        WORKERS.with_borrow_mut(|workers| take(workers, &worker, &event));
    });
    closure.into_js_value().unchecked_into()
}

/// By a timer, since frames may end before.
fn end_idle_later() {
    let end = Closure::once_into_js(|| {
        let is_used = |seat: &Seat| seat.call.is_some() || seat.since.elapsed() < IDLE;
        WORKERS.with_borrow_mut(|workers| workers.seats.retain(is_used));
    });
    if let Some(window) = web_sys::window() {
        let (end, delay) = (end.unchecked_ref(), 2 * IDLE.as_millis() as i32);
        // Without a timer they stay.
        let _ = window.set_timeout_with_callback_and_timeout_and_arguments_0(end, delay);
    }
}

/// Calls `then` of a promise.
pub(super) fn then(promise: &JsValue, functions: &[JsValue]) -> Result<JsValue, JsValue> {
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
