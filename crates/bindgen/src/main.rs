//! Writes what JavaScript needs to call a wasm module: `hullwright_bindgen MODULE.wasm FOLDER`.

use std::process::ExitCode;

use wasm_bindgen_cli_support::Bindgen;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [module, folder] = arguments.as_slice() else {
        eprintln!("usage: hullwright_bindgen MODULE.wasm FOLDER");
        return ExitCode::FAILURE;
    };
    let mut bindgen = Bindgen::new();
    let prepared = bindgen.typescript(true).web(true).and_then(|bindgen| {
        // Whoever instantiates says where the module is: no bundler has to guess.
        let bindgen = bindgen.remove_name_section(true).remove_producers_section(true);
        bindgen.input_path(module).omit_default_module_path(true).generate(folder)
    });
    match prepared {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{module}: {error:#}");
            ExitCode::FAILURE
        }
    }
}
