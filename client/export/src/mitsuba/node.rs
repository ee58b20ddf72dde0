//! A tree of Mitsuba's objects, as XML and as what `mitsuba.load_dict` takes.

use crate::matrix::Matrix;
use serde_json::{Map, json};
use std::fmt::Write;

/// A plugin with its properties.
#[derive(Debug, Clone)]
pub struct Node {
    /// Its element in XML: `bsdf`, `shape`...
    element: &'static str,
    plugin: &'static str,
    id: Option<String>,
    /// In the order in which they were given.
    properties: Vec<(String, Value)>,
}

/// A property.
#[derive(Debug, Clone)]
pub enum Value {
    Number(f64),
    Integer(i64),
    Switch(bool),
    Text(&'static str),
    /// A path below the export's folder.
    File(String),
    /// A colour of linear RGB.
    Rgb([f64; 3]),
    /// The same number at all wavelengths; may be above 1, where a reflectance in RGB may not.
    Uniform(f64),
    Point([f64; 3]),
    Direction([f64; 3]),
    Matrix(Matrix),
    /// A node with an id of the same scene.
    Reference(String),
    Node(Node),
}

impl Node {
    pub fn new(element: &'static str, plugin: &'static str) -> Self {
        Self { element, plugin, id: None, properties: Vec::new() }
    }

    #[must_use]
    pub fn with(mut self, name: &str, value: Value) -> Self {
        self.properties.push((name.to_owned(), value));
        self
    }

    /// Gives it the id that references name.
    #[must_use]
    pub fn called(mut self, id: &str) -> Self {
        self.id = Some(id.to_owned());
        self
    }

    /// A file for Mitsuba 3.
    pub fn to_xml(&self) -> String {
        let mut out = "<scene version=\"3.0.0\">\n".to_owned();
        for (name, value) in &self.properties {
            xml(&mut out, 1, name, value);
        }
        out.push_str("</scene>\n");
        out
    }

    /// A tree for `scene.py`: matrices and files are marked, since JSON has neither.
    pub fn to_object(&self) -> serde_json::Value {
        let mut object = Map::new();
        object.insert("type".to_owned(), self.plugin.into());
        if let Some(id) = &self.id {
            object.insert("id".to_owned(), id.as_str().into());
        }
        for (name, value) in &self.properties {
            object.insert(name.clone(), value.to_object());
        }
        object.into()
    }
}

impl Value {
    fn to_object(&self) -> serde_json::Value {
        match self {
            Self::Number(number) => json!(number),
            Self::Integer(number) => json!(number),
            Self::Switch(switch) => json!(switch),
            Self::Text(text) => json!(text),
            Self::File(path) => json!({ "file": path }),
            Self::Rgb(rgb) => json!({ "type": "rgb", "value": rgb }),
            Self::Uniform(number) => json!({ "type": "uniform", "value": number }),
            Self::Point(xyz) | Self::Direction(xyz) => json!(xyz),
            Self::Matrix(matrix) => json!({ "matrix": matrix }),
            Self::Reference(id) => json!({ "type": "ref", "id": id }),
            Self::Node(node) => node.to_object(),
        }
    }
}

fn xml(out: &mut String, depth: usize, name: &str, value: &Value) {
    let pad = "    ".repeat(depth);
    let list = |values: &[f64]| values.iter().map(f64::to_string).collect::<Vec<_>>().join(" ");
    let line = |element: &str, text: &str| format!("{pad}<{element} name=\"{name}\" value=\"{text}\"/>\n");
    // Writing to a string cannot fail.
    let text = match value {
        Value::Number(number) => line("float", &number.to_string()),
        Value::Integer(number) => line("integer", &number.to_string()),
        Value::Switch(switch) => line("boolean", &switch.to_string()),
        Value::Text(text) => line("string", text),
        Value::File(path) => line("string", path),
        Value::Rgb(rgb) => line("rgb", &list(rgb)),
        Value::Uniform(number) => line("spectrum", &number.to_string()),
        Value::Point([x, y, z]) => format!("{pad}<point name=\"{name}\" x=\"{x}\" y=\"{y}\" z=\"{z}\"/>\n"),
        Value::Direction([x, y, z]) => format!("{pad}<vector name=\"{name}\" x=\"{x}\" y=\"{y}\" z=\"{z}\"/>\n"),
        Value::Matrix(matrix) => format!(
            "{pad}<transform name=\"{name}\">\n{pad}    <matrix value=\"{}\"/>\n{pad}</transform>\n",
            list(matrix.as_flattened())
        ),
        Value::Reference(id) => format!("{pad}<ref name=\"{name}\" id=\"{id}\"/>\n"),
        Value::Node(node) => {
            let id = node.id.as_deref().map_or(String::new(), |id| format!(" id=\"{id}\""));
            let _ = writeln!(out, "{pad}<{} type=\"{}\" name=\"{name}\"{id}>", node.element, node.plugin);
            for (name, value) in &node.properties {
                xml(out, depth + 1, name, value);
            }
            format!("{pad}</{}>\n", node.element)
        }
    };
    out.push_str(&text);
}
