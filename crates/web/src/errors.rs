//! Errors with codes.

use std::fmt::Display;

use hullwright::hulls_format::HullsFileError;
use hullwright::{Error, ParseError};
use wasm_bindgen::JsValue;

/// An `Error` of JavaScript.
pub fn error(code: &str, message: &dyn Display) -> JsValue {
    let error = js_sys::Error::new(&message.to_string());
    // An object that was just made takes any property.
    let _ = js_sys::Reflect::set(&error, &"code".into(), &code.into());
    error.into()
}

/// An error of the library.
pub fn library(reason: Error) -> JsValue {
    error(reason.code(), &reason)
}

/// A text that is no parameter.
pub fn parameter(reason: ParseError) -> JsValue {
    error("invalid_parameter", &reason)
}

/// A `.hulls` file that can't be read or written.
pub fn hulls_file(reason: HullsFileError) -> JsValue {
    error("hulls_file", &reason)
}

/// Arguments that do not fit together.
pub fn argument(reason: &str) -> JsValue {
    error("invalid_argument", &reason)
}
