//! HDF5 files, and MATLAB MAT files of version 7.3, which are such.

use super::{Column, Values, WIDEST, columns_of};
use hdf5_pure::{DType, Dataset, File};

/// The vectors and matrices of real numbers that lie in the root of the file.
pub(super) fn columns(bytes: Vec<u8>) -> Result<Vec<Column>, String> {
    let is_matlab = bytes.starts_with(b"MATLAB");
    let file = File::from_bytes(bytes).map_err(|error| error.to_string())?;
    let mut names = file.root().datasets().map_err(|error| error.to_string())?;
    names.sort();
    let mut columns = Vec::new();
    for name in names {
        let dataset = file.dataset(&name).map_err(|error| error.to_string())?;
        columns.extend(columns_in(&name, &dataset, is_matlab)?);
    }
    Ok(columns)
}

/// The columns of one dataset; none where it is no vector or matrix of real numbers.
fn columns_in(name: &str, dataset: &Dataset, is_matlab: bool) -> Result<Vec<Column>, String> {
    let refuse = |error: hdf5_pure::Error| format!("`{name}`: {error}");
    let shape = dataset.shape().map_err(refuse)?;
    // MATLAB stores column by column and so tells the dimensions in reverse.
    let (rows, width) = match (shape.as_slice(), is_matlab) {
        ([rows], _) => (*rows, 1),
        ([width, rows], true) | ([rows, width], false) => (*rows, *width),
        _ => return Ok(Vec::new()),
    };
    let (rows, width) = if rows == 1 { (width, 1) } else { (rows, width) };
    if rows == 0 || !(1..=WIDEST as u64).contains(&width) {
        return Ok(Vec::new());
    }
    let Some(values) = values(dataset).transpose().map_err(refuse)? else {
        return Ok(Vec::new());
    };
    let (rows, width) = (rows as usize, width as usize);
    if rows.checked_mul(width) != Some(values.len()) {
        return Err(format!(
            "`{name}` has another number of values than it says"
        ));
    }
    let values = if is_matlab || width == 1 {
        values
    } else {
        by_columns(values, rows, width)
    };
    Ok(columns_of(name, width, values))
}

fn values(dataset: &Dataset) -> Option<Result<Values, hdf5_pure::Error>> {
    fn whole<T: Into<i64>>(
        list: Result<Vec<T>, hdf5_pure::Error>,
    ) -> Result<Values, hdf5_pure::Error> {
        list.map(|list| Values::Whole(list.into_iter().map(Into::into).collect()))
    }
    let read = match dataset.dtype() {
        Ok(DType::F64) => dataset.read_f64().map(Values::Floats),
        Ok(DType::F32) => {
            let floats = |list: Vec<f32>| list.into_iter().map(f64::from).collect();
            dataset.read_f32().map(|list| Values::Floats(floats(list)))
        }
        Ok(DType::I8) => whole(dataset.read_i8()),
        Ok(DType::U8) => whole(dataset.read_u8()),
        Ok(DType::I16) => whole(dataset.read_i16()),
        Ok(DType::U16) => whole(dataset.read_u16()),
        Ok(DType::I32) => whole(dataset.read_i32()),
        Ok(DType::U32) => whole(dataset.read_u32()),
        Ok(DType::I64) => dataset.read_i64().map(Values::Whole),
        Ok(DType::U64) => dataset.read_u64().map(Values::Large),
        Ok(_) => return None,
        Err(error) => Err(error),
    };
    Some(read)
}

/// Values that are stored row by row, column by column.
fn by_columns(values: Values, rows: usize, width: usize) -> Values {
    fn turned<T: Copy>(list: &[T], rows: usize, width: usize) -> Vec<T> {
        let places = (0..width).flat_map(|at| (0..rows).map(move |row| row * width + at));
        places
            .filter_map(|place| list.get(place).copied())
            .collect()
    }
    match values {
        Values::Floats(list) => Values::Floats(turned(&list, rows, width)),
        Values::Whole(list) => Values::Whole(turned(&list, rows, width)),
        Values::Large(list) => Values::Large(turned(&list, rows, width)),
        texts @ Values::Texts(_) => texts,
    }
}
