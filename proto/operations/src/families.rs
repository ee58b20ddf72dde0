//! Metrics as they are at one moment, in Prometheus' text format.

use crate::distribution::BOUNDS;
use crate::{COMMIT, Distribution};
use prometheus::TextEncoder;
use prometheus::proto::{Bucket, Counter, Gauge, Histogram, LabelPair, Metric, MetricFamily, MetricType};

/// Families of metrics. Programs count as suits them, and say here what they have counted; names follow Prometheus'
/// conventions: `gonio_`, the program, what is counted, its base unit, and `_total` for what only grows.
#[derive(Debug, Default)]
pub struct Families(Vec<MetricFamily>);

/// A number that floats hold exactly up to 2^53: centuries of counting.
#[allow(clippy::cast_precision_loss)]
fn float(value: u64) -> f64 {
    value as f64
}

impl Families {
    /// What every program says of itself: its build, and nothing else yet.
    #[must_use]
    pub fn new() -> Self {
        let mut families = Self::default();
        let mut build = Metric::from_gauge(gauge(1.0));
        build.set_label(vec![label("version", env!("CARGO_PKG_VERSION")), label("commit", COMMIT)]);
        families.add(
            "gonio_build_info",
            "Always 1; its labels are the program's version and commit.",
            GAUGE,
            vec![build],
        );
        families
    }

    /// What only grows.
    pub fn counter(&mut self, name: &str, help: &str, value: u64) {
        self.add(name, help, COUNTER, vec![counted(float(value))]);
    }

    /// What only grows, apart by the value of one label. A family without a member is left out.
    pub fn counters<L: AsRef<str>>(
        &mut self,
        name: &str,
        help: &str,
        key: &str,
        values: impl IntoIterator<Item = (L, f64)>,
    ) {
        let metrics = values.into_iter().map(|(value, count)| {
            let mut metric = counted(count);
            metric.set_label(vec![label(key, value.as_ref())]);
            metric
        });
        self.add(name, help, COUNTER, metrics.collect());
    }

    /// What is now.
    pub fn gauge(&mut self, name: &str, help: &str, value: u64) {
        self.add(name, help, GAUGE, vec![Metric::from_gauge(gauge(float(value)))]);
    }

    /// What is now, apart by the value of one label.
    pub fn gauges<'a>(&mut self, name: &str, help: &str, key: &str, values: impl IntoIterator<Item = (&'a str, u64)>) {
        let metrics = values.into_iter().map(|(value, now)| {
            let mut metric = Metric::from_gauge(gauge(float(now)));
            metric.set_label(vec![label(key, value)]);
            metric
        });
        self.add(name, help, GAUGE, metrics.collect());
    }

    /// How long things took.
    pub fn histogram(&mut self, name: &str, help: &str, distribution: &Distribution) {
        let cumulative = distribution.cumulative();
        let mut histogram = Histogram::default();
        histogram.set_sample_count(cumulative[BOUNDS.len()]);
        histogram.set_sample_sum(distribution.seconds());
        let bucket = |(bound, count): (&f64, &u64)| {
            let mut bucket = Bucket::default();
            bucket.set_upper_bound(*bound);
            bucket.set_cumulative_count(*count);
            bucket
        };
        histogram.set_bucket(BOUNDS.iter().zip(&cumulative).map(bucket).collect());
        let mut metric = Metric::default();
        metric.set_histogram(histogram);
        self.add(name, help, MetricType::HISTOGRAM, vec![metric]);
    }

    fn add(&mut self, name: &str, help: &str, kind: MetricType, metrics: Vec<Metric>) {
        if metrics.is_empty() {
            return;
        }
        let mut family = MetricFamily::default();
        family.set_name(name.to_owned());
        family.set_help(help.to_owned());
        family.set_field_type(kind);
        family.set_metric(metrics);
        self.0.push(family);
    }

    /// All of it, as text format 0.0.4.
    ///
    /// # Errors
    /// A family has no name.
    pub(crate) fn text(&self) -> prometheus::Result<String> {
        TextEncoder::new().encode_to_string(&self.0)
    }
}

const COUNTER: MetricType = MetricType::COUNTER;
const GAUGE: MetricType = MetricType::GAUGE;

fn counted(value: f64) -> Metric {
    let (mut metric, mut counter) = (Metric::default(), Counter::default());
    counter.set_value(value);
    metric.set_counter(counter);
    metric
}

fn gauge(value: f64) -> Gauge {
    let mut gauge = Gauge::default();
    gauge.set_value(value);
    gauge
}

fn label(key: &str, value: &str) -> LabelPair {
    let mut label = LabelPair::default();
    label.set_name(key.to_owned());
    label.set_value(value.to_owned());
    label
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    #[test]
    fn text_is_what_prometheus_reads() {
        let mut families = Families::new();
        let distribution = Distribution::default();
        distribution.add(Duration::from_millis(2));
        families.counter("gonio_x_tasks_total", "Tasks.", 3);
        families.counters("gonio_x_seconds_total", "Time.", "worker", [("a \"b\"\n\\", 0.5)]);
        families.counters("gonio_x_none_total", "Nobody.", "worker", Vec::<(String, f64)>::new());
        families.gauges("gonio_x_state", "State.", "state", [("serving", 1), ("standby", 0)]);
        families.histogram("gonio_x_task_seconds", "How long.", &distribution);
        let text = families.text().unwrap();
        let has = |line: &str| assert!(text.lines().any(|l| l == line), "{line} is not in {text}");
        has("# TYPE gonio_x_tasks_total counter");
        has("gonio_x_tasks_total 3");
        has(r#"gonio_x_seconds_total{worker="a \"b\"\n\\"} 0.5"#);
        has(r#"gonio_x_state{state="standby"} 0"#);
        has(r#"gonio_x_task_seconds_bucket{le="0.001"} 0"#);
        has(r#"gonio_x_task_seconds_bucket{le="0.003"} 1"#);
        has(r#"gonio_x_task_seconds_bucket{le="+Inf"} 1"#);
        has("gonio_x_task_seconds_sum 0.002");
        has("gonio_x_task_seconds_count 1");
        assert!(text.contains(&format!("commit=\"{COMMIT}\"")) && !text.contains("none"));
    }
}
