//! Runs the program in a folder of its own.
#![allow(dead_code)]

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// A folder that is removed at the end of the test.
pub struct Place(tempfile::TempDir);

/// What a run left behind.
pub struct Ran {
    pub code: Option<i32>,
    pub out: String,
    pub err: String,
}

impl Place {
    pub fn new() -> Place {
        Place(tempfile::tempdir().unwrap())
    }

    pub fn path(&self) -> &Path {
        self.0.path()
    }

    /// Writes a file; gives its name for a command line.
    pub fn file(&self, name: &str, content: impl AsRef<[u8]>) -> String {
        fs::write(self.path().join(name), content).unwrap();
        name.to_owned()
    }

    /// The cart and a record of so many samples; gives their names.
    pub fn cart(&self, samples: usize) -> (String, String) {
        let record = cart_record(samples);
        (self.file("m.toml", CART), self.file("r.csv", record))
    }

    pub fn read(&self, name: &str) -> String {
        fs::read_to_string(self.path().join(name)).unwrap()
    }

    /// The program, to be run in this folder.
    pub fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_veribound"));
        command.current_dir(self.path()).args(arguments);
        command
    }

    pub fn run(&self, arguments: &[&str]) -> Ran {
        Ran::of(self.command(arguments).output().unwrap())
    }

    /// Runs the program with these words, none of which holds a blank.
    pub fn typed(&self, line: &str) -> Ran {
        let words: Vec<&str> = line.split_whitespace().collect();
        self.run(&words)
    }

    /// Runs `observe MODEL RECORD -o out` with more flags; no figures and no page, to be quick.
    pub fn observe(&self, model: &str, record: &str, more: &[&str]) -> Ran {
        let mut arguments = vec!["observe", model, record, "-o", "out"];
        arguments.extend(["--figures", "none", "--report", "none"]);
        arguments.extend(more);
        self.run(&arguments)
    }

    /// The files below `folder`, sorted, by their paths in it.
    pub fn files(&self, folder: &str) -> Vec<String> {
        fn collect(folder: &Path, root: &Path, found: &mut Vec<String>) {
            let Ok(entries) = fs::read_dir(folder) else {
                return;
            };
            for path in entries.map(|entry| entry.unwrap().path()) {
                if path.is_dir() {
                    collect(&path, root, found);
                } else {
                    found.push(path.strip_prefix(root).unwrap().display().to_string());
                }
            }
        }
        let root = self.path().join(folder);
        let mut found = Vec::new();
        collect(&root, &root, &mut found);
        found.sort();
        found
    }
}

impl Ran {
    pub fn of(output: Output) -> Ran {
        Ran {
            code: output.status.code(),
            out: String::from_utf8(output.stdout).unwrap(),
            err: String::from_utf8(output.stderr).unwrap(),
        }
    }

    /// Asserts the exit code, showing what was said where it is another.
    pub fn ended(self, code: i32) -> Ran {
        assert_eq!(
            self.code,
            Some(code),
            "stdout:\n{}\nstderr:\n{}",
            self.out,
            self.err
        );
        self
    }
}

/// The folder of an example.
pub fn example(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../examples")
        .join(name)
}

/// The files of the drive train example.
pub fn rig(name: &str) -> String {
    example("drive-train").join(name).display().to_string()
}

/// A small model: a cart that is driven, `x' = k u`.
pub const CART: &str = "\
format = 1
states = [\"x [m]\"]
init.x = [-1, 1]
inputs = [\"u [V]\"]
params.k = { unit = \"m/(V*s)\", bounds = [0, 4] }
der.x = \"k * u\"
outputs.pos = \"x +- 0.1 [m]\"
";

/// A record of the cart with `k = 2`.
pub fn cart_record(samples: usize) -> String {
    let mut text = String::from("t,u,pos\n");
    for k in 0..samples {
        let t = k as f64 / 10.0;
        text += &format!("{t:.1},1,{:.1}\n", 2.0 * t);
    }
    text
}

/// Lower and upper bounds of a column of a result table, by row.
pub fn bounds(table: &str, name: &str) -> Vec<(f64, f64)> {
    let mut rows = csv::Reader::from_reader(table.as_bytes());
    let header = rows.headers().unwrap().clone();
    let column = |end: &str| {
        let wanted = format!("{name}.{end}");
        header.iter().position(|known| known == wanted).unwrap()
    };
    let (lo, hi) = (column("lo"), column("hi"));
    rows.records()
        .map(|row| {
            let row = row.unwrap();
            (row[lo].parse().unwrap(), row[hi].parse().unwrap())
        })
        .collect()
}
