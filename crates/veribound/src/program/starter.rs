//! `veribound new`: a folder with an example that runs.

use super::Outcome;
use super::arguments::New;
use super::ending::Ending;
use super::message::{say, say_json};
use clap::ValueEnum;
use serde::Serialize;
use std::fmt::Write as _;
use std::path::Path;
use veribound_data::{CompleteFile, ResultFolder};
use veribound_model::diagnostic::Diagnostic;

/// Names of examples.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Example {
    /// A motor with a belt and dry friction: 80 s of torque and angle
    DriveTrain,
    /// A tank that spills above an unknown height, and one below it
    TwoTanks,
    /// Impacts, infinitely many at the end
    BouncingBall,
    /// A drug in blood and tissue: three rates from both sides
    Compartments,
    /// Prey and predators, also without a record
    LotkaVolterra,
}

/// What an example consists of.
struct Parts {
    /// What it is about, in a sentence.
    about: &'static str,
    /// Files by their names.
    files: &'static [(&'static str, &'static str)],
    /// Commands for a folder of these files, and what each shows.
    commands: &'static [(&'static str, &'static str)],
}

macro_rules! file {
    ($example:literal, $name:literal) => {
        (
            $name,
            include_str!(concat!("../../../../examples/", $example, "/", $name)),
        )
    };
}

const CHECK: (&str, &str) = (
    "veribound check model.toml",
    "What the model file was understood to say.",
);

impl Example {
    fn parts(self) -> Parts {
        match self {
            Example::DriveTrain => Parts {
                about: "A motor turns a shaft over a toothed belt, with dry friction. Torque and angle are recorded 100 \
                        times a second for 80 s; damping, gain and friction level are unknown.",
                files: &[
                    file!("drive-train", "model.toml"),
                    file!("drive-train", "rig.csv"),
                    file!("drive-train", "profile.csv"),
                ],
                commands: &[
                    CHECK,
                    (
                        "veribound observe model.toml rig.csv -o out",
                        "Bounds sample by sample; open `out/report.html`.",
                    ),
                    (
                        "veribound observe model.toml rig.csv -o second --start-from out",
                        "A second pass starts from what the first one left.",
                    ),
                    (
                        "veribound identify model.toml rig.csv -o id --to 20",
                        "Bounds from both sides, from the first 20 s as a whole.",
                    ),
                ],
            },
            Example::TwoTanks => Parts {
                about: "Water runs through two tanks; the upper one spills above an unknown height.",
                files: &[
                    file!("two-tanks", "model.toml"),
                    file!("two-tanks", "record.csv"),
                    file!("two-tanks", "profile.csv"),
                ],
                commands: &[
                    CHECK,
                    (
                        "veribound observe model.toml record.csv -o out",
                        "Bounds sample by sample; open `out/report.html`.",
                    ),
                ],
            },
            Example::BouncingBall => Parts {
                about: "A ball falls, bounces, and comes to rest after infinitely many impacts.",
                files: &[
                    file!("bouncing-ball", "model.toml"),
                    file!("bouncing-ball", "record.csv"),
                ],
                commands: &[
                    CHECK,
                    (
                        "veribound observe model.toml record.csv --every 2 -o out",
                        "Bounds sample by sample; open `out/report.html`.",
                    ),
                ],
            },
            Example::Compartments => Parts {
                about: "A drug drips into the blood and spreads into tissue; both are measured, three rates are unknown.",
                files: &[
                    file!("compartments", "model.toml"),
                    file!("compartments", "record.csv"),
                    file!("compartments", "profile.csv"),
                ],
                commands: &[
                    CHECK,
                    (
                        "veribound identify model.toml record.csv -o id",
                        "Bounds from both sides; open `id/report.html`.",
                    ),
                ],
            },
            Example::LotkaVolterra => Parts {
                about: "Prey and predators: all their courses, for a range of rates.",
                files: &[
                    file!("lotka-volterra", "model.toml"),
                    file!("lotka-volterra", "record.csv"),
                ],
                commands: &[
                    CHECK,
                    (
                        "veribound enclose model.toml --until 5 --every 0.05 --sample 8 -o tube",
                        "All courses over five years, and eight true ones; open `tube/report.html`.",
                    ),
                    (
                        "veribound identify model.toml record.csv -o id",
                        "Rates from a record, from both sides.",
                    ),
                ],
            },
        }
    }

    fn name(self) -> String {
        let value = self.to_possible_value();
        value.map_or_else(String::new, |value| value.get_name().to_owned())
    }
}

/// What is told as JSON.
#[derive(Serialize)]
struct Made {
    folder: String,
    example: String,
    files: Vec<String>,
    commands: Vec<&'static str>,
}

/// Makes the folder, and tells how to go on.
pub fn run(arguments: &New) -> Outcome {
    let path = arguments.name.as_path();
    refuse_used(path)?;
    let parts = arguments.example.parts();
    let folder = ResultFolder::create(path)?;
    let readme = readme(path, arguments.example, &parts);
    let texts = parts.files.iter().map(|(name, text)| (*name, *text));
    let texts: Vec<(&str, &str)> = texts.chain([("README.md", readme.as_str())]).collect();
    let written = texts
        .iter()
        .map(|(name, text)| folder.write(name, text.as_bytes()));
    let written: Vec<CompleteFile> = written.collect::<Result<_, _>>()?;
    written
        .into_iter()
        .try_for_each(CompleteFile::put_in_place)?;
    let made = Made {
        folder: path.display().to_string(),
        example: arguments.example.name(),
        files: texts.iter().map(|(name, _)| (*name).to_owned()).collect(),
        commands: parts.commands.iter().map(|(command, _)| *command).collect(),
    };
    if arguments.json {
        say_json(&made)?;
    } else {
        say(&told(&made));
    }
    Ok(Ending::Done)
}

/// Refuses a place where there is something.
fn refuse_used(path: &Path) -> Result<(), Diagnostic> {
    let is_empty = path
        .read_dir()
        .map_or(true, |mut entries| entries.next().is_none());
    if is_empty && !path.is_file() {
        return Ok(());
    }
    let message = format!("`{}` is there already", path.display());
    Err(Diagnostic::new("E0615", message).help("choose another name; nothing of yours is replaced"))
}

fn told(made: &Made) -> String {
    let mut text = format!("  {}: {}\n", made.folder, made.files.join(", "));
    // Writing to a String cannot fail.
    let _ = writeln!(text, "  go on with\n    cd {}", made.folder);
    for command in &made.commands {
        let _ = writeln!(text, "    {command}");
    }
    text
}

/// The text that goes with the files.
fn readme(path: &Path, example: Example, parts: &Parts) -> String {
    let name = path.file_name().map_or_else(
        || path.display().to_string(),
        |name| name.to_string_lossy().into_owned(),
    );
    let mut text = format!(
        "# {name}\n\nThe example `{}` of veribound. {}\n",
        example.name(),
        parts.about
    );
    for (command, shows) in parts.commands {
        let _ = write!(text, "\n{shows}\n\n```sh\n{command}\n```\n");
    }
    text.push_str(
        "\nTo make it yours: write your equations, units and error bounds into `model.toml`, and take a record of your own \
         (CSV, MATLAB MAT, HDF5 or Parquet). `veribound check model.toml` says what was understood, and `veribound explain` \
         what a message means.\n",
    );
    text
}
