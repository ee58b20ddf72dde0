//! Asks every call for a token whose roles it needs, before anything of the call is read.

use super::tokens::Grant;
use super::{Roles, Tokens};
use futures::future::{Either, Ready, ready};
use std::sync::Arc;
use std::task::{Context, Poll};
use tonic::Status;
use tonic::codegen::http::{HeaderMap, Request, Response, header::AUTHORIZATION};
use tower::{Layer, Service};

/// Answered to everybody who connects: what it tells is whether the coordinator serves, and probes have no token.
const HEALTH: &str = "/grpc.health.v1.Health/";

/// Puts a service behind tokens; without any, everybody who connects may call everything.
#[derive(Debug, Clone)]
pub struct Guard {
    tokens: Option<Arc<Tokens>>,
}

impl Guard {
    /// By these tokens.
    #[must_use]
    pub fn new(tokens: Option<Tokens>) -> Self {
        Self { tokens: tokens.map(Arc::new) }
    }

    /// Whether tokens are asked for.
    #[must_use]
    pub fn asks(&self) -> bool {
        self.tokens.is_some()
    }

    /// Whether who shows this `Authorization` has one of `roles`.
    ///
    /// # Errors
    /// No token where one is asked for, or an unknown one.
    pub fn allows(&self, authorization: Option<&str>, roles: Roles) -> Result<bool, Status> {
        Ok(self.grant(authorization)?.is_none_or(|grant| roles.meet(grant.roles)))
    }

    /// What an `Authorization` grants; `None` where nothing is asked for, and all is granted.
    fn grant(&self, authorization: Option<&str>) -> Result<Option<&Grant>, Status> {
        let Some(tokens) = &self.tokens else { return Ok(None) };
        let Some(given) = authorization else {
            return Err(Status::unauthenticated("this farm asks for a token; name its file with --token"));
        };
        let token = given.split_once(' ').filter(|(scheme, _)| scheme.eq_ignore_ascii_case("bearer"));
        match token.and_then(|(_, token)| tokens.grant(token.trim())) {
            Some(grant) => Ok(Some(grant)),
            None => Err(Status::unauthenticated("the token is unknown here; ask who runs the farm for one")),
        }
    }

    fn admit(&self, path: &str, headers: &HeaderMap) -> Result<(), Status> {
        if path.starts_with(HEALTH) {
            return Ok(());
        }
        let given = headers.get(AUTHORIZATION).map(|given| given.to_str().unwrap_or_default());
        let Some(grant) = self.grant(given)? else { return Ok(()) };
        if Roles::for_call(path).is_some_and(|needed| needed.meet(grant.roles)) {
            return Ok(());
        }
        tracing::warn!(token = grant.name, roles = %grant.roles, path, "refused: not among the token's roles");
        Err(Status::permission_denied(format!(
            "the token of {} has the roles {}, which do not allow this",
            grant.name, grant.roles
        )))
    }
}

impl<S> Layer<S> for Guard {
    type Service = Guarded<S>;

    fn layer(&self, inner: S) -> Guarded<S> {
        Guarded { inner, guard: self.clone() }
    }
}

/// A service behind a [`Guard`].
#[derive(Debug, Clone)]
pub struct Guarded<S> {
    inner: S,
    guard: Guard,
}

impl<S, B, R> Service<Request<B>> for Guarded<S>
where
    S: Service<Request<B>, Response = Response<R>>,
    R: Default,
{
    type Response = Response<R>;
    type Error = S::Error;
    type Future = Either<Ready<Result<Response<R>, S::Error>>, S::Future>;

    fn poll_ready(&mut self, context: &mut Context<'_>) -> Poll<Result<(), S::Error>> {
        self.inner.poll_ready(context)
    }

    fn call(&mut self, request: Request<B>) -> Self::Future {
        match self.guard.admit(request.uri().path(), request.headers()) {
            Ok(()) => Either::Right(self.inner.call(request)),
            Err(status) => Either::Left(ready(Ok(status.into_http()))),
        }
    }
}
