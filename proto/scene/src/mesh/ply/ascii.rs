//! The payload of an ascii PLY: one element a line.

use ply_rs_bw::ply::{ElementDef, PropertyType};

use super::super::number::number;

/// The lines behind the header. Blank ones are passed over, and an element may go on in the next line.
pub(super) struct Lines<'a> {
    rest: &'a [u8],
    /// The number of the line that was read last, counted from 1.
    line: usize,
    words: Vec<&'a [u8]>,
}

impl<'a> Lines<'a> {
    /// `header` is the number of lines before `payload`.
    pub(super) fn new(payload: &'a [u8], header: usize) -> Self {
        Self { rest: payload, line: header, words: Vec::new() }
    }

    /// What was not read.
    pub(super) fn rest(&self) -> &'a [u8] {
        self.rest
    }

    /// Reads one element and gives every value to `put`, with the number of its property.
    ///
    /// # Errors
    /// What is wrong, naming the line: no number, too few of them in the file, too many in the line.
    pub(super) fn element(&mut self, element: &ElementDef, mut put: impl FnMut(usize, f64)) -> Result<(), String> {
        self.words.clear();
        let mut read = 0;
        for (property, definition) in element.properties.values().enumerate() {
            let mut values = 1.0;
            if matches!(definition.data_type, PropertyType::List(..)) {
                values = self.value(&mut read)?;
                if !(values >= 0.0 && values.fract() == 0.0) {
                    return Err(format!("Line {}: has a list of {values} values", self.line));
                }
            }
            // A count beyond the file's end stops there.
            while values > 0.0 {
                values -= 1.0;
                put(property, self.value(&mut read)?);
            }
        }
        if read < self.words.len() {
            return Err(format!("Line {}: has {} values, {read} are announced", self.line, self.words.len()));
        }
        Ok(())
    }

    fn value(&mut self, read: &mut usize) -> Result<f64, String> {
        while *read >= self.words.len() {
            if self.rest.is_empty() {
                return Err(format!("Line {}: the file ends inside of an element", self.line));
            }
            // Of words that were read, none is needed again.
            self.words.clear();
            *read = 0;
            let end = self.rest.iter().position(|&byte| byte == b'\n').map_or(self.rest.len(), |newline| newline + 1);
            let (line, rest) = self.rest.split_at(end);
            self.rest = rest;
            self.line += 1;
            self.words.extend(line.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty()));
        }
        let word = self.words.get(*read).copied().unwrap_or_default();
        *read += 1;
        number(word).ok_or_else(|| {
            let shown: String = String::from_utf8_lossy(word).chars().take(40).collect();
            format!("Line {}: {shown} is no number", self.line)
        })
    }
}
