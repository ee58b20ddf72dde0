//! What has changed between two states, as a JSON merge patch (RFC 7396).

use serde_json::{Map, Value};

/// The patch that makes `to` of `from`; empty where they are equal. Members that are null count as absent, for a merge patch
/// cannot set them.
#[must_use]
pub fn difference(from: &Map<String, Value>, to: &Map<String, Value>) -> Map<String, Value> {
    let mut patch = Map::new();
    for key in from.keys().filter(|key| to.get(*key).is_none_or(Value::is_null)) {
        patch.insert(key.clone(), Value::Null);
    }
    for (key, value) in to.iter().filter(|(_, value)| !value.is_null()) {
        match (from.get(key), value) {
            (Some(Value::Object(before)), Value::Object(after)) => {
                let inner = difference(before, after);
                if !inner.is_empty() {
                    patch.insert(key.clone(), Value::Object(inner));
                }
            }
            (Some(before), after) if before == after => {}
            _ => {
                patch.insert(key.clone(), value.clone());
            }
        }
    }
    patch
}

/// Removes members that are null: numbers that JSON cannot hold, options that are absent.
pub(crate) fn prune(state: &mut Map<String, Value>) {
    state.retain(|_, value| !value.is_null());
    for value in state.values_mut() {
        if let Value::Object(inner) = value {
            prune(inner);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn object(value: Value) -> Map<String, Value> {
        let Value::Object(map) = value else { panic!("no object") };
        map
    }

    /// RFC 7396, section 2, as `stream.js` does it, too.
    fn merge(target: &mut Map<String, Value>, patch: &Map<String, Value>) {
        for (key, value) in patch {
            match value {
                Value::Null => {
                    target.remove(key);
                }
                Value::Object(inner) => {
                    let member = target.entry(key.clone()).or_insert_with(|| json!({}));
                    if !member.is_object() {
                        *member = json!({});
                    }
                    let Value::Object(member) = member else { continue };
                    merge(member, inner);
                }
                other => {
                    target.insert(key.clone(), other.clone());
                }
            }
        }
    }

    #[test]
    fn a_patch_makes_one_state_of_the_other() {
        let states = [
            json!({}),
            json!({ "a": 1, "b": { "c": 2, "d": [1, 2] } }),
            json!({ "a": { "x": 1 }, "b": { "c": 3, "d": [1, 2] } }),
            json!({ "b": { "d": [2], "e": {} } }),
            json!({ "b": 7, "z": { "y": { "x": "w" } } }),
        ];
        for from in &states {
            for to in &states {
                let (from, to) = (object(from.clone()), object(to.clone()));
                let patch = difference(&from, &to);
                assert_eq!(patch.is_empty(), from == to);
                let mut merged = from.clone();
                merge(&mut merged, &patch);
                assert_eq!(merged, to, "{patch:?}");
            }
        }
    }

    #[test]
    fn only_what_has_changed_is_sent() {
        let from = object(json!({ "loss": { "1": 9.0, "2": 3.0 }, "name": "a" }));
        let to = object(json!({ "loss": { "1": 9.0, "2": 3.0, "3": 1.0 }, "name": "a", "none": null }));
        assert_eq!(difference(&from, &to), object(json!({ "loss": { "3": 1.0 } })));
    }

    #[test]
    fn what_is_null_is_absent() {
        let mut state = object(json!({ "a": null, "b": { "c": f64::NAN, "d": 1 } }));
        prune(&mut state);
        assert_eq!(state, object(json!({ "b": { "d": 1 } })));
    }
}
