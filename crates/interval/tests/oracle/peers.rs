//! The library of `peers/`, loaded at run time: inari, built as its own instructions want it.

use std::ffi::c_void;
use std::path::PathBuf;

use libloading::{Library, Symbol};
use veribound_interval::Interval;

/// Has to be that of the library.
const INTERFACE: u32 = 1;

#[repr(C)]
struct Column {
    lo: *const f64,
    hi: *const f64,
}

type Prepare = unsafe extern "C" fn(*const u8, usize, *const Column, usize, usize) -> *mut c_void;
type Pass = unsafe extern "C" fn(*mut c_void);
type Read = unsafe extern "C" fn(*const c_void, *mut f64, *mut f64);

/// The functions of the library, which stays loaded as long as they are there.
pub struct Peers {
    prepare: Prepare,
    pass: Pass,
    read: Read,
    free: Pass,
    _library: Library,
}

/// Arguments and results of one operation inside the library.
pub struct Batch<'a> {
    peers: &'a Peers,
    inside: *mut c_void,
    count: usize,
}

impl Peers {
    /// The build with this name in the folder `VERIBOUND_PEERS`; `None` where that is not set.
    pub fn load(build: &str) -> Result<Option<Peers>, String> {
        let Some(folder) = std::env::var_os("VERIBOUND_PEERS") else {
            return Ok(None);
        };
        let (prefix, suffix) = (std::env::consts::DLL_PREFIX, std::env::consts::DLL_SUFFIX);
        let path = PathBuf::from(folder)
            .join(build)
            .join("release")
            .join(format!("{prefix}veribound_peers{suffix}"));
        let failed = |error| format!("{}: {error}", path.display());
        // SAFETY: the library of this repository has no code that runs when it is loaded, and the types
        // are those of its interface, whose number is compared before anything else is called.
        unsafe {
            let library = Library::new(&path).map_err(failed)?;
            let interface: Symbol<unsafe extern "C" fn() -> u32> =
                library.get(b"peer_interface").map_err(failed)?;
            if interface() != INTERFACE {
                return Err(format!(
                    "{}: built from another version; run peers/build",
                    path.display()
                ));
            }
            Ok(Some(Peers {
                prepare: *library.get::<Prepare>(b"peer_prepare").map_err(failed)?,
                pass: *library.get::<Pass>(b"peer_pass").map_err(failed)?,
                read: *library.get::<Read>(b"peer_read").map_err(failed)?,
                free: *library.get::<Pass>(b"peer_free").map_err(failed)?,
                _library: library,
            }))
        }
    }

    /// A batch of the operation with this name; `None` if the library has none with so many arguments.
    pub fn prepare(&self, name: &str, columns: &[Vec<Interval>]) -> Option<Batch<'_>> {
        let count = columns.first()?.len();
        assert!(columns.iter().all(|column| column.len() == count));
        let ends: Vec<(Vec<f64>, Vec<f64>)> = columns
            .iter()
            .map(|column| column.iter().map(|x| (x.lo(), x.hi())).unzip())
            .collect();
        let pointers: Vec<Column> = ends
            .iter()
            .map(|(lo, hi)| Column {
                lo: lo.as_ptr(),
                hi: hi.as_ptr(),
            })
            .collect();
        // SAFETY: all pointers are to vectors alive during the call, with the lengths that are told.
        let inside = unsafe {
            (self.prepare)(
                name.as_ptr(),
                name.len(),
                pointers.as_ptr(),
                pointers.len(),
                count,
            )
        };
        (!inside.is_null()).then(|| Batch {
            peers: self,
            inside,
            count,
        })
    }

    /// The results of the operation with this name.
    #[allow(dead_code, reason = "the benchmark only takes times")]
    pub fn evaluate(&self, name: &str, columns: &[Vec<Interval>]) -> Option<Vec<Interval>> {
        let mut batch = self.prepare(name, columns)?;
        batch.pass();
        Some(batch.read())
    }
}

impl Batch<'_> {
    /// The operation on all cases.
    pub fn pass(&mut self) {
        // SAFETY: the batch comes from this library and is borrowed for writing.
        unsafe { (self.peers.pass)(self.inside) }
    }

    /// The results of the last pass.
    #[allow(dead_code, reason = "the benchmark only takes times")]
    pub fn read(&self) -> Vec<Interval> {
        let (mut lo, mut hi) = (vec![0.0; self.count], vec![0.0; self.count]);
        // SAFETY: there is room for as many ends as the batch has cases.
        unsafe { (self.peers.read)(self.inside, lo.as_mut_ptr(), hi.as_mut_ptr()) };
        let interval = |(lo, hi)| Interval::new(lo, hi).unwrap_or(Interval::EMPTY);
        lo.into_iter().zip(hi).map(interval).collect()
    }
}

impl Drop for Batch<'_> {
    fn drop(&mut self) {
        // SAFETY: the batch comes from this library and ends here.
        unsafe { (self.peers.free)(self.inside) }
    }
}
