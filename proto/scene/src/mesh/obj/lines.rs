//! The lines of an OBJ file, as the library can read them.

use std::collections::BTreeSet;
use std::io::{BufRead, Read, Result as IoResult};

use super::super::number::number;

/// The lines of an OBJ file that shape its surface, one buffer each.
///
/// The library would take a polyline (`l`) for a polygon, give up at a name that is not UTF-8, at a line that goes on in
/// the next one and at a number of an old C library, and split a mesh at every group; and it does not tell in which line
/// it found an error, which the number here does.
#[derive(Default)]
pub(super) struct Geometry<'a> {
    rest: &'a [u8],
    statement: Vec<u8>,
    read: usize,
    /// Of the last line that was read, from 1.
    pub number: usize,
    /// Whether texture coordinates and materials are wanted.
    look: bool,
    materials: BTreeSet<&'a [u8]>,
    parts: BTreeSet<&'a [u8]>,
    colours: bool,
    textures: bool,
    /// The libraries of materials that it names.
    pub libraries: Vec<&'a [u8]>,
    /// Materials in the order in which they are first used; the first has no name.
    pub groups: Vec<&'a [u8]>,
    /// Index of the material that counts.
    group: u32,
    /// By face: index of its material.
    pub group_of: Vec<u32>,
}

impl<'a> Geometry<'a> {
    pub fn new(bytes: &'a [u8], look: bool) -> Self {
        Self { rest: bytes, look, groups: vec![b""], ..Self::default() }
    }

    fn line(&mut self) -> &'a [u8] {
        let end = self.rest.iter().position(|&byte| byte == b'\n').map_or(self.rest.len(), |newline| newline + 1);
        let (line, rest) = self.rest.split_at(end);
        self.rest = rest;
        self.number += 1;
        line.trim_ascii()
    }

    fn next_statement(&mut self) {
        self.statement.clear();
        self.read = 0;
        let line = self.line();
        let keyword = line.split(u8::is_ascii_whitespace).next().unwrap_or_default();
        let named = line.get(keyword.len()..).unwrap_or_default().trim_ascii();
        match keyword {
            b"f" if self.look => self.group_of.push(self.group),
            b"v" | b"vn" | b"f" => {}
            b"vt" if self.look => {}
            // A polyline's further lines belong to it, too.
            _ => {
                match keyword {
                    b"usemtl" => self.use_material(named),
                    b"mtllib" => self.libraries.push(named),
                    b"o" | b"g" => _ = self.parts.insert(named),
                    b"vt" => self.textures = true,
                    _ => {}
                }
                let mut last = line;
                while !keyword.starts_with(b"#") && last.ends_with(b"\\") && !self.rest.is_empty() {
                    last = self.line();
                }
                return;
            }
        }
        let mut last = line;
        while let Some(goes_on) = last.strip_suffix(b"\\") {
            self.statement.extend(goes_on);
            self.statement.push(b' ');
            last = self.line();
            if self.rest.is_empty() {
                break;
            }
        }
        self.statement.extend(last);
        if keyword != b"f" {
            self.plain_numbers();
            let values = self.statement.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty()).count() - 1;
            self.colours |= keyword == b"v" && values >= 6;
        }
        self.statement.push(b'\n');
    }

    fn use_material(&mut self, name: &'a [u8]) {
        self.materials.insert(name);
        if self.look {
            let known = self.groups.iter().position(|group| *group == name);
            let index = known.unwrap_or_else(|| {
                self.groups.push(name);
                self.groups.len() - 1
            });
            self.group = u32::try_from(index).unwrap_or(u32::MAX);
        }
    }

    /// Writes the numbers that only [`number`] can read as the library reads them.
    fn plain_numbers(&mut self) {
        let foreign = |word: &&[u8]| std::str::from_utf8(word).is_ok_and(|text| text.parse::<f64>().is_err());
        let words = || self.statement.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
        if !words().skip(1).any(|word| foreign(&word)) {
            return;
        }
        let plain = |word: &[u8]| match number(word) {
            Some(value) => format!("{value:?}").into_bytes(),
            None => word.to_vec(),
        };
        self.statement = words().map(plain).collect::<Vec<_>>().join(&b' ');
    }

    pub fn remarks(&self) -> Vec<String> {
        let mut remarks = Vec::new();
        if self.parts.len() > 1 {
            remarks.push(format!("has {} groups or objects, which become one", self.parts.len()));
        }
        if self.materials.len() > 1 {
            remarks.push(format!("names {} materials, which are not used", self.materials.len()));
        }
        if self.colours {
            remarks.push("has vertex colours, which are not used".to_owned());
        }
        if self.textures {
            remarks.push("has texture coordinates, which are not used".to_owned());
        }
        remarks
    }
}

impl BufRead for Geometry<'_> {
    fn fill_buf(&mut self) -> IoResult<&[u8]> {
        while self.read >= self.statement.len() && !self.rest.is_empty() {
            self.next_statement();
        }
        Ok(self.statement.get(self.read..).unwrap_or_default())
    }

    fn consume(&mut self, amount: usize) {
        self.read = self.read.saturating_add(amount);
    }
}

impl Read for Geometry<'_> {
    fn read(&mut self, target: &mut [u8]) -> IoResult<usize> {
        let count = self.fill_buf()?.read(target)?;
        self.consume(count);
        Ok(count)
    }
}
