//! Takes the plotting library of the page out of the crate `plotly`, compressed.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::{Compression, write::GzEncoder};
use std::error::Error;
use std::io::Write;
use std::path::PathBuf;

fn main() -> Result<(), Box<dyn Error>> {
    println!("cargo:rerun-if-changed=build.rs");
    // The scripts of a page that needs no network: plotly.js first, then what draws formulas.
    let scripts = plotly::Plot::offline_js_sources();
    let library = scripts
        .split_once('>')
        .and_then(|(_, rest)| rest.split_once("</script>"))
        .map(|(library, _)| library)
        .filter(|library| library.contains("plotly.js v"))
        .ok_or("the crate `plotly` has no plotly.js where it was")?;
    let mut packed = GzEncoder::new(Vec::new(), Compression::best());
    packed.write_all(library.as_bytes())?;
    let place = PathBuf::from(std::env::var("OUT_DIR")?).join("plotly.js.gz.base64");
    std::fs::write(place, STANDARD.encode(packed.finish()?))?;
    Ok(())
}
