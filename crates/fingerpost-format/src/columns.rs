//! Tables of numbers as text: a header of column names, commas between.

use thiserror::Error;

/// A table that cannot be used.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum ColumnsError {
    /// A column is missing in the header.
    #[error("its first line names no column {name:?}; it needs {wanted}, in any order, with commas between")]
    Missing {
        /// The column.
        name: &'static str,
        /// All that are needed.
        wanted: String,
    },
    /// Something else than a number.
    #[error(
        "line {line} has {text:?} in column {name:?}, which is no finite number; mend or remove the line"
    )]
    NotANumber {
        /// Line number, from one.
        line: usize,
        /// The column.
        name: &'static str,
        /// What stands there; empty where the line is too short.
        text: String,
    },
    /// Time runs backwards or stands still.
    #[error("line {line} is no later than the line before it; sort the lines by time")]
    NotLater {
        /// Line number, from one.
        line: usize,
    },
    /// There is nothing below the header.
    #[error("it has no line below its header; check what wrote it")]
    Empty,
}

/// The named columns of every line, the first of them a time that grows from line to line. Other columns and empty lines are
/// passed over.
pub(crate) fn parse_columns<const N: usize>(
    text: &str,
    names: [&'static str; N],
) -> Result<Vec<[f64; N]>, ColumnsError> {
    let rows = lines(text, names)?.collect::<Result<Vec<_>, _>>()?;
    if rows.is_empty() { Err(ColumnsError::Empty) } else { Ok(rows) }
}

/// The same without the lines that cannot be used, with what is wrong with them; an error where they are half of all or more.
pub(crate) fn parse_usable_columns<const N: usize>(
    text: &str,
    names: [&'static str; N],
) -> Result<(Vec<[f64; N]>, Vec<ColumnsError>), ColumnsError> {
    let (mut rows, mut wrong) = (Vec::new(), Vec::new());
    for line in lines(text, names)? {
        match line {
            Ok(row) => rows.push(row),
            Err(error) => wrong.push(error),
        }
    }
    if wrong.len() < rows.len() {
        return Ok((rows, wrong));
    }
    Err(wrong.into_iter().next().unwrap_or(ColumnsError::Empty))
}

fn lines<const N: usize>(
    text: &str,
    names: [&'static str; N],
) -> Result<impl Iterator<Item = Result<[f64; N], ColumnsError>>, ColumnsError> {
    let mut lines = text.lines().enumerate();
    let header: Vec<&str> = lines
        .next()
        .map_or("", |(_, line)| line)
        .trim_start_matches('\u{feff}')
        .split(',')
        .map(str::trim)
        .collect();
    let mut places = [0; N];
    for (place, name) in places.iter_mut().zip(names) {
        let found = header.iter().position(|column| *column == name);
        *place = found.ok_or_else(|| ColumnsError::Missing { name, wanted: names.join(", ") })?;
    }
    let mut last_s = f64::NEG_INFINITY;
    Ok(lines.filter(|(_, line)| !line.trim().is_empty()).map(move |(index, line)| {
        let row = numbers(line, index + 1, names, places)?;
        if row[0] <= last_s {
            return Err(ColumnsError::NotLater { line: index + 1 });
        }
        last_s = row[0];
        Ok(row)
    }))
}

fn numbers<const N: usize>(
    text: &str,
    line: usize,
    names: [&'static str; N],
    places: [usize; N],
) -> Result<[f64; N], ColumnsError> {
    let fields: Vec<&str> = text.split(',').map(str::trim).collect();
    let mut row = [0.0; N];
    for ((number, place), name) in row.iter_mut().zip(places).zip(names) {
        let text = fields.get(place).copied().unwrap_or_default();
        let read = text.parse::<f64>().ok().filter(|read| read.is_finite());
        *number = read.ok_or_else(|| ColumnsError::NotANumber { line, name, text: text.to_owned() })?;
    }
    Ok(row)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_come_in_any_order_and_others_are_passed_over() {
        let rows = parse_columns("b, x,a\n2,9,1\n\n4,9,3\n", ["a", "b"]).unwrap();
        assert_eq!(rows, [[1.0, 2.0], [3.0, 4.0]]);
    }

    #[test]
    fn what_cannot_be_used_is_named() {
        let parse = |text: &str| parse_columns(text, ["a", "b"]).unwrap_err().to_string();
        assert!(parse("a,c\n1,2\n").contains("\"b\""));
        assert!(parse("a,b\n1,2\n2,x\n").contains("line 3"));
        assert!(parse("a,b\n1\n").contains("line 2"));
        assert!(parse("a,b\n1,inf\n").contains("inf"));
        assert!(parse("a,b\n1,2\n1,2\n").contains("line 3"));
        assert!(parse("a,b\n").contains("no line"));
    }

    #[test]
    fn lines_that_cannot_be_used_are_left_out_while_they_are_few() {
        let parse = |text: &str| parse_usable_columns(text, ["a", "b"]);
        let (rows, wrong) = parse("a,b\n1,1\n2,nan\n3,3\n3,4\n2,5\n4,6\n5,7\n").unwrap();
        assert_eq!(rows, [[1.0, 1.0], [3.0, 3.0], [4.0, 6.0], [5.0, 7.0]]);
        assert!(matches!(wrong[0], ColumnsError::NotANumber { line: 3, .. }));
        assert_eq!(wrong[1..], [ColumnsError::NotLater { line: 5 }, ColumnsError::NotLater { line: 6 }]);
        assert_eq!(parse("a,b\n1,1\n1,2\n"), Err(ColumnsError::NotLater { line: 3 }));
        assert_eq!(parse("a,b\n"), Err(ColumnsError::Empty));
    }
}
