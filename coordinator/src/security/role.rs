//! Roles, and which of them each call of the protocol needs.

use std::fmt;
use std::str::FromStr;

/// What a token is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// Sends captures, evaluates, cancels: clients.
    Submit,
    /// Takes tasks and reads what they need: workers.
    Work,
    /// Sees what runs, and changes nothing.
    Watch,
}

/// A set of roles.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Roles(u8);

impl Role {
    /// Every role.
    pub const ALL: [Self; 3] = [Self::Submit, Self::Work, Self::Watch];

    /// Its name in files and on command lines.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Submit => "submit",
            Self::Work => "work",
            Self::Watch => "watch",
        }
    }
}

impl FromStr for Role {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        Self::ALL
            .into_iter()
            .find(|role| role.name() == text)
            .ok_or(format!("{text:?} is no role: submit, work, watch"))
    }
}

impl Roles {
    /// The set of these.
    #[must_use]
    pub fn of(roles: &[Role]) -> Self {
        Self(roles.iter().fold(0, |set, role| set | 1 << *role as u8))
    }

    /// Whether the two sets share a role.
    #[must_use]
    pub fn meet(self, other: Self) -> bool {
        self.0 & other.0 != 0
    }

    /// Those of which one suffices to call the method of this path (`/gonio.farm.v1.Farm/Work`); `None` where there is no such
    /// method. A method that is added to the protocol is refused to all until it has a line here.
    #[must_use]
    pub fn for_call(path: &str) -> Option<Self> {
        let service = format!("/{}/", gonio_proto::wire::farm_server::SERVICE_NAME);
        let roles: &[Role] = match path.strip_prefix(&service)? {
            "Work" | "Beat" => &[Role::Work],
            "GetBlob" => &[Role::Work, Role::Submit],
            "Evaluate" | "PutBlob" | "Cancel" => &[Role::Submit],
            // Which of some files are there is also how a client finds out whether anybody answers.
            "Jobs" | "MissingBlobs" => &[Role::Submit, Role::Watch],
            _ => return None,
        };
        Some(Self::of(roles))
    }
}

impl FromStr for Roles {
    type Err = String;

    /// Names with commas between.
    fn from_str(text: &str) -> Result<Self, String> {
        let roles: Vec<Role> = text.split(',').map(|name| name.trim().parse()).collect::<Result<_, _>>()?;
        Ok(Self::of(&roles))
    }
}

impl fmt::Display for Roles {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let has = |role: &Role| self.meet(Self::of(&[*role]));
        let names: Vec<&str> = Role::ALL.iter().filter(|role| has(role)).map(|role| role.name()).collect();
        f.write_str(&names.join(","))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn roles_are_written_as_they_are_read() {
        let roles: Roles = "watch, submit".parse().unwrap();
        assert_eq!(roles.to_string(), "submit,watch");
        assert!(roles.meet(Roles::of(&[Role::Watch])) && !roles.meet(Roles::of(&[Role::Work])));
        assert!("submit,wach".parse::<Roles>().unwrap_err().contains("wach"));
    }

    /// The protocol's own description, so that a new method cannot be forgotten.
    #[test]
    fn every_method_of_the_protocol_has_its_roles() {
        let farm = include_str!("../../../proto/farm.proto");
        let methods: Vec<&str> =
            farm.lines().filter_map(|l| l.trim().strip_prefix("rpc ")?.split('(').next()).collect();
        assert!(methods.len() >= 8);
        for method in methods {
            let path = format!("/{}/{method}", gonio_proto::wire::farm_server::SERVICE_NAME);
            assert!(Roles::for_call(&path).is_some(), "{method}");
        }
        assert_eq!(Roles::for_call("/grpc.reflection.v1.ServerReflection/ServerReflectionInfo"), None);
    }
}
