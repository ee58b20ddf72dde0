//! An authority of a test, and what it signs.

use gonio::farm::Access;
use rcgen::{
    BasicConstraints, CertificateParams, ExtendedKeyUsagePurpose, IsCa, Issuer, KeyPair, KeyUsagePurpose, date_time_ymd,
};
use std::path::{Path, PathBuf};

/// An authority with a folder for its files.
pub struct Authority {
    issuer: Issuer<'static, KeyPair>,
    folder: PathBuf,
    name: String,
}

/// A certificate and its key, as files.
pub struct Signed {
    pub cert: PathBuf,
    pub key: PathBuf,
}

impl Authority {
    /// A new authority, whose certificate is `<name>.pem` in `folder`.
    pub fn new(folder: &Path, name: &str) -> Self {
        let mut params = CertificateParams::new(Vec::new()).unwrap();
        params.is_ca = IsCa::Ca(BasicConstraints::Unconstrained);
        params.key_usages = vec![KeyUsagePurpose::KeyCertSign, KeyUsagePurpose::DigitalSignature];
        let key = KeyPair::generate().unwrap();
        std::fs::write(folder.join(format!("{name}.pem")), params.self_signed(&key).unwrap().pem()).unwrap();
        Self { issuer: Issuer::new(params, key), folder: folder.to_owned(), name: name.to_owned() }
    }

    /// The authority's certificate.
    pub fn certificate(&self) -> PathBuf {
        self.folder.join(format!("{}.pem", self.name))
    }

    /// Signs a certificate: of `server` for that end of a connection to this machine, of others for the other end.
    pub fn sign(&self, name: &str) -> Signed {
        self.sign_until(name, 4096)
    }

    /// The same, valid until this year begins.
    pub fn sign_until(&self, name: &str, year: i32) -> Signed {
        let names = ["localhost", "127.0.0.1", "gonio-coordinator"].map(str::to_owned).to_vec();
        let mut params = CertificateParams::new(names).unwrap();
        let serves = name == "server";
        params.extended_key_usages =
            vec![if serves { ExtendedKeyUsagePurpose::ServerAuth } else { ExtendedKeyUsagePurpose::ClientAuth }];
        params.not_before = date_time_ymd(2000, 1, 1);
        params.not_after = date_time_ymd(year, 1, 1);
        let key = KeyPair::generate().unwrap();
        let file = |what: &str| self.folder.join(format!("{}-{name}.{what}.pem", self.name));
        let signed = Signed { cert: file("cert"), key: file("key") };
        std::fs::write(&signed.cert, params.signed_by(&key, &self.issuer).unwrap().pem()).unwrap();
        std::fs::write(&signed.key, key.serialize_pem()).unwrap();
        signed
    }
}

impl Signed {
    /// How a farm of `authority` is reached with this certificate.
    pub fn access(&self, authority: &Authority) -> Access {
        Access {
            ca: Some(authority.certificate()),
            cert: Some(self.cert.clone()),
            key: Some(self.key.clone()),
            ..Access::default()
        }
    }
}
