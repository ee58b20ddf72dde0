//! What of KEDA's API (keda.sh/v1alpha1) the manifests use: every key that is not here is refused.

use k8s_openapi::api::autoscaling::v2::HorizontalPodAutoscalerBehavior;
use serde::Deserialize;

const VERSION: &str = "keda.sh/v1alpha1";

/// What an object is called.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Metadata {
    pub name: String,
    /// Written by kustomize.
    pub namespace: Option<String>,
}

impl Metadata {
    /// Fails unless the object is the farm's, and in its namespace if it is in one.
    pub fn check(&self) {
        assert!(self.name.starts_with("gonio-"));
        assert!(self.namespace.as_deref().is_none_or(|namespace| namespace == "gonio"), "{:?}", self.namespace);
    }
}

/// What scales a deployment.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct ScaledObject {
    pub api_version: String,
    pub kind: String,
    pub metadata: Metadata,
    pub spec: ScaledObjectSpec,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct ScaledObjectSpec {
    pub scale_target_ref: Named,
    pub min_replica_count: u32,
    pub max_replica_count: u32,
    pub cooldown_period: u32,
    pub polling_interval: u32,
    pub advanced: Advanced,
    pub triggers: Vec<Trigger>,
}

/// A reference by name.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Named {
    pub name: String,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct Advanced {
    pub horizontal_pod_autoscaler_config: AutoscalerConfig,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AutoscalerConfig {
    pub behavior: HorizontalPodAutoscalerBehavior,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct Trigger {
    #[serde(rename = "type")]
    pub kind: String,
    pub metadata: TriggerMetadata,
    pub authentication_ref: Named,
}

/// Texts all: KEDA passes them to the scaler as they are.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct TriggerMetadata {
    pub scaler_address: String,
    pub slots: String,
}

/// Where KEDA finds what it shows to a scaler.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct TriggerAuthentication {
    pub api_version: String,
    pub kind: String,
    pub metadata: Metadata,
    pub spec: TriggerAuthenticationSpec,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct TriggerAuthenticationSpec {
    pub secret_target_ref: Vec<SecretTarget>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SecretTarget {
    pub parameter: String,
    pub name: String,
    pub key: String,
}

/// Fails unless the two belong together and say what KEDA needs.
pub fn check(scaled: &ScaledObject, authentication: &TriggerAuthentication) {
    assert_eq!([&*scaled.api_version, &*authentication.api_version], [VERSION; 2]);
    assert_eq!((&*scaled.kind, &*authentication.kind), ("ScaledObject", "TriggerAuthentication"));
    let spec = &scaled.spec;
    assert!(spec.min_replica_count < spec.max_replica_count);
    assert!(spec.cooldown_period >= spec.polling_interval);
    let down = spec.advanced.horizontal_pod_autoscaler_config.behavior.scale_down.as_ref().unwrap();
    assert!(down.stabilization_window_seconds.unwrap() > 0);
    assert_eq!((spec.triggers.len(), &*spec.triggers[0].kind), (1, "external-push"));
    assert_eq!(spec.triggers[0].authentication_ref.name, authentication.metadata.name);
    let targets = &authentication.spec.secret_target_ref;
    let parameters: Vec<&str> = targets.iter().map(|target| &*target.parameter).collect();
    assert_eq!(parameters, ["caCert", "tlsClientCert", "tlsClientKey"]);
    let keys: Vec<&str> = targets.iter().map(|target| &*target.key).collect();
    assert_eq!(keys, ["ca.crt", "tls.crt", "tls.key"]);
}
