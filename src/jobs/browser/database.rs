//! The cache of a browser: an IndexedDB with the bytes of a `.hulls` file per mesh and parameters,
//! within a number of bytes. Tabs may share it. Answers come in later frames, so a frame only
//! looks whether one is there.
//!
//! JavaScript's values stay on their thread, so what is here belongs to the thread of the game, and
//! a [`Look`] names what it waits for by a number.

use std::cell::RefCell;
use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use bevy::platform::time::Instant;
use hullwright::hulls_format::HullsFile;
use js_sys::{Array, Date, Reflect, Uint8Array};
use wasm_bindgen::prelude::{Closure, JsCast, JsValue};
use web_sys::{IdbDatabase, IdbObjectStore, IdbRequest, IdbTransaction, IdbTransactionMode};

use crate::jobs::kept::{is_usable, kept, unseen};
use crate::jobs::request::ContentKey;

/// The stores of the database, both by the name of a result: its bytes, and how many they are and
/// when they were used last, which can be looked at without reading the bytes.
const STORES: [&str; 2] = ["hulls", "uses"];

/// A browser may never answer, and entities wait meanwhile. Longer than any frame, after which
/// answers come.
const PATIENCE: Duration = Duration::from_secs(10);

/// Empty: what handles of the native store share is thread-local here.
#[derive(Debug, Default)]
pub(in crate::jobs) struct DiskState;

/// A database of results, the least recently used of which are removed.
#[derive(Debug, Clone)]
pub(in crate::jobs) struct DiskCache {
    name: String,
    budget: u64,
}

/// A look-up of one result.
#[derive(Debug)]
pub(in crate::jobs) struct Look(u64);

/// What has become of a look-up.
pub(super) enum Answer {
    Pending,
    Found(Box<HullsFile>),
    Missing,
}

#[derive(Default)]
enum State {
    #[default]
    NotAsked,
    Opening,
    Open(IdbDatabase),
    /// It can't be used.
    Failed,
}

#[derive(Default)]
struct Database {
    state: State,
    looks: u64,
    /// What is to be looked up when it is open.
    waiting: Vec<(u64, String)>,
    /// When each look-up began that is not answered.
    pending: HashMap<u64, Instant>,
    answers: HashMap<u64, Option<Vec<u8>>>,
    /// Bytes that may be written before the database is looked at again.
    unseen: i64,
}

thread_local! {
    static DATABASE: RefCell<Database> = RefCell::default();
}

impl DiskCache {
    pub(in crate::jobs) fn new(directory: PathBuf, budget: u64, _state: Arc<DiskState>) -> Self {
        Self { name: directory.to_string_lossy().into_owned(), budget }
    }

    /// Begins to look for a result; `None` where there is no database.
    pub(super) fn look(&self, key: ContentKey) -> Option<Look> {
        let name = key.name()?;
        DATABASE.with_borrow_mut(|database| {
            if matches!(database.state, State::NotAsked) {
                database.state = State::Opening;
                if let Err(error) = open(&self.name) {
                    database.fail(&error);
                }
            }
            if matches!(database.state, State::Failed) {
                return None;
            }
            database.looks += 1;
            let look = database.looks;
            database.pending.insert(look, Instant::now());
            database.waiting.push((look, name));
            database.send_waiting();
            Some(Look(look))
        })
    }

    /// Keeps a result. The decomposition succeeded, whether or not this does.
    pub(in crate::jobs) fn write(&self, key: ContentKey, file: &HullsFile) {
        let (Some(name), Ok(bytes)) = (key.name(), file.to_bytes()) else { return };
        DATABASE.with_borrow_mut(|database| {
            let State::Open(open) = &database.state else { return };
            database.unseen -= bytes.len() as i64;
            let is_full = database.unseen < 0;
            let written = write(open, &name, &bytes).and_then(|()| match is_full {
                true => evict(open, self.budget),
                false => Ok(()),
            });
            match written {
                Err(error) => database.fail(&error),
                Ok(()) if is_full => database.unseen = unseen(self.budget),
                Ok(()) => {}
            }
        });
    }
}

impl Look {
    pub(super) fn answer(&self) -> Answer {
        let bytes = DATABASE.with_borrow_mut(|database| {
            let is_late =
                database.pending.get(&self.0).is_some_and(|since| since.elapsed() > PATIENCE);
            if is_late {
                database.fail(&"it does not answer".into());
            }
            database.answers.remove(&self.0)
        });
        let Some(bytes) = bytes else { return Answer::Pending };
        // What can't be read counts as missing.
        match bytes.and_then(|bytes| HullsFile::from_bytes(&bytes).ok()) {
            Some(file) if is_usable(&file) => Answer::Found(Box::new(file)),
            _ => Answer::Missing,
        }
    }
}

impl Drop for Look {
    fn drop(&mut self) {
        DATABASE.with_borrow_mut(|database| {
            database.waiting.retain(|(look, _)| *look != self.0);
            database.pending.remove(&self.0);
            database.answers.remove(&self.0);
        });
    }
}

impl Database {
    fn send_waiting(&mut self) {
        let State::Open(database) = &self.state else { return };
        let database = database.clone();
        for (look, name) in std::mem::take(&mut self.waiting) {
            if let Err(error) = read(&database, look, &name) {
                return self.fail(&error);
            }
        }
    }

    fn answer(&mut self, look: u64, bytes: Option<Vec<u8>>) {
        if self.pending.remove(&look).is_some() {
            self.answers.insert(look, bytes);
        }
    }

    /// From now on there is no cache. Said once.
    fn fail(&mut self, error: &JsValue) {
        if !matches!(self.state, State::Failed) {
            log::warn!("hulls are not cached, since IndexedDB fails: {}", text(error));
        }
        self.state = State::Failed;
        self.waiting.clear();
        let all: Vec<u64> = self.pending.keys().copied().collect();
        all.into_iter().for_each(|look| self.answer(look, None));
    }
}

fn open(name: &str) -> Result<(), JsValue> {
    let window = web_sys::window().ok_or("there is no window")?;
    let factory = window.indexed_db()?.ok_or("there is none")?;
    let request = factory.open_with_u32(name, 1)?;
    let opening = request.clone();
    let upgrade = Closure::once_into_js(move || -> Result<(), JsValue> {
        let database: IdbDatabase = opening.result()?.dyn_into()?;
        STORES.iter().try_for_each(|store| database.create_object_store(store).map(drop))
    });
    request.set_onupgradeneeded(Some(upgrade.unchecked_ref()));
    on_end(&request, |opened| {
        DATABASE.with_borrow_mut(|database| {
            match opened.and_then(|opened| opened.dyn_into::<IdbDatabase>()) {
                // Too late.
                Ok(_) if !matches!(database.state, State::Opening) => {}
                Ok(opened) => {
                    database.state = State::Open(opened);
                    database.send_waiting();
                }
                Err(error) => database.fail(&error),
            }
        });
    });
    Ok(())
}

fn read(database: &IdbDatabase, look: u64, name: &str) -> Result<(), JsValue> {
    let (_, [hulls, _]) = stores(database, IdbTransactionMode::Readonly)?;
    let (name, database) = (name.to_owned(), database.clone());
    on_end(&hulls.get(&name.as_str().into())?, move |found| {
        let bytes = found.ok().and_then(|found| found.dyn_into::<Uint8Array>().ok());
        let bytes = bytes.map(|bytes| bytes.to_vec());
        if let Some(bytes) = &bytes {
            // Where this fails, the result is removed earlier.
            let _ = stores(&database, IdbTransactionMode::Readwrite)
                .and_then(|(_, [_, uses])| used(&uses, &name, bytes.len()));
        }
        DATABASE.with_borrow_mut(|database| database.answer(look, bytes));
    });
    Ok(())
}

fn write(database: &IdbDatabase, name: &str, bytes: &[u8]) -> Result<(), JsValue> {
    let (transaction, [hulls, uses]) = stores(database, IdbTransactionMode::Readwrite)?;
    // As where the browser has no more room for this page.
    let aborted = transaction.clone();
    let fail = Closure::once_into_js(move || {
        let error = error_of(&aborted).unwrap_or("a transaction was aborted".into());
        DATABASE.with_borrow_mut(|database| database.fail(&error));
    });
    transaction.set_onabort(Some(fail.unchecked_ref()));
    hulls.put_with_key(&Uint8Array::from(bytes), &name.into())?;
    used(&uses, name, bytes.len())
}

/// Notes that a result was used.
fn used(uses: &IdbObjectStore, name: &str, bytes: usize) -> Result<(), JsValue> {
    let use_of = Array::of2(&Date::now().into(), &(bytes as f64).into());
    uses.put_with_key(&use_of, &name.into()).map(drop)
}

/// Removes the least recently used results until the rest is within the budget.
fn evict(database: &IdbDatabase, budget: u64) -> Result<(), JsValue> {
    let (_, [hulls, uses]) = stores(database, IdbTransactionMode::Readwrite)?;
    let names = uses.get_all_keys()?;
    on_end(&uses.get_all()?, move |all| {
        let (Ok(names), Ok(all)) = (names.result(), all) else { return };
        let number = |of: &JsValue, index: u32| {
            Reflect::get_u32(of, index).ok().and_then(|value| value.as_f64()).unwrap_or_default()
        };
        let all = Array::from(&names).into_iter().zip(Array::from(&all));
        let mut all: Vec<(f64, f64, JsValue)> =
            all.map(|(name, of)| (number(&of, 0), number(&of, 1), name)).collect();
        let mut bytes: f64 = all.iter().map(|(_, bytes, _)| bytes).sum();
        if bytes <= budget as f64 {
            return;
        }
        all.sort_by(|(a, ..), (b, ..)| a.total_cmp(b));
        let kept = kept(budget) as f64;
        for (_, size, name) in all {
            if bytes <= kept {
                break;
            }
            // What stays is removed next time.
            let _ = hulls.delete(&name).and_then(|_| uses.delete(&name));
            bytes -= size;
        }
    });
    Ok(())
}

fn stores(
    database: &IdbDatabase,
    mode: IdbTransactionMode,
) -> Result<(IdbTransaction, [IdbObjectStore; 2]), JsValue> {
    let names: Array = STORES.iter().map(|name| JsValue::from(*name)).collect();
    let transaction = database.transaction_with_str_sequence_and_mode(&names, mode)?;
    let [hulls, uses] = STORES;
    let stores = [transaction.object_store(hulls)?, transaction.object_store(uses)?];
    Ok((transaction, stores))
}

/// Calls a function with what a request ends in.
fn on_end(request: &IdbRequest, end: impl FnOnce(Result<JsValue, JsValue>) + 'static) {
    let ended = request.clone();
    let end = Closure::once_into_js(move || {
        end(error_of(&ended).map_or_else(|| ended.result(), Err));
    });
    request.set_onsuccess(Some(end.unchecked_ref()));
    request.set_onerror(Some(end.unchecked_ref()));
}

/// The error of a request or a transaction.
fn error_of(of: &JsValue) -> Option<JsValue> {
    Reflect::get(of, &"error".into()).ok().filter(|error| !error.is_falsy())
}

fn text(error: &JsValue) -> String {
    let message =
        Reflect::get(error, &"message".into()).ok().and_then(|message| message.as_string());
    message.or_else(|| error.as_string()).unwrap_or_else(|| "an unknown error".into())
}
