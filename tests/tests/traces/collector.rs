//! A collector of spans, over real gRPC.

#![allow(clippy::unwrap_used)]

use opentelemetry_proto::tonic::collector::trace::v1::trace_service_server::{TraceService, TraceServiceServer};
use opentelemetry_proto::tonic::collector::trace::v1::{ExportTraceServiceRequest, ExportTraceServiceResponse};
use opentelemetry_proto::tonic::common::v1::any_value::Value;
use std::sync::{Arc, Mutex};
use tokio::net::TcpListener;
use tokio_stream::wrappers::TcpListenerStream;
use tonic::{Request, Response, Status};

/// A span as it came.
#[derive(Debug, Clone)]
pub struct Heard {
    /// The program that sent it.
    pub service: String,
    pub name: String,
    pub trace: Vec<u8>,
    pub id: Vec<u8>,
    /// Empty where it has none.
    pub parent: Vec<u8>,
    /// Nanoseconds since 1970.
    pub begin: u64,
    pub end: u64,
}

pub struct Collector {
    pub url: String,
    heard: Arc<Mutex<Vec<Heard>>>,
}

impl Collector {
    /// Listens on a free port, for as long as the runtime lives.
    pub async fn start() -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let url = format!("http://{}", listener.local_addr().unwrap());
        let heard = Arc::<Mutex<Vec<Heard>>>::default();
        let server = tonic::transport::Server::builder()
            .add_service(TraceServiceServer::new(Ear(Arc::clone(&heard))))
            .serve_with_incoming(TcpListenerStream::new(listener));
        tokio::spawn(server);
        Self { url, heard }
    }

    pub fn spans(&self) -> Vec<Heard> {
        self.heard.lock().unwrap().clone()
    }
}

struct Ear(Arc<Mutex<Vec<Heard>>>);

#[tonic::async_trait]
impl TraceService for Ear {
    async fn export(
        &self,
        request: Request<ExportTraceServiceRequest>,
    ) -> Result<Response<ExportTraceServiceResponse>, Status> {
        for of_process in request.into_inner().resource_spans {
            let attributes = of_process.resource.unwrap_or_default().attributes;
            let name = attributes.into_iter().find(|a| a.key == "service.name").and_then(|a| a.value?.value);
            let Some(Value::StringValue(service)) = name else { return Err(Status::invalid_argument("no name")) };
            let spans = of_process.scope_spans.into_iter().flat_map(|scope| scope.spans);
            self.0.lock().unwrap().extend(spans.map(|span| Heard {
                service: service.clone(),
                name: span.name,
                trace: span.trace_id,
                id: span.span_id,
                parent: span.parent_span_id,
                begin: span.start_time_unix_nano,
                end: span.end_time_unix_nano,
            }));
        }
        Ok(Response::new(ExportTraceServiceResponse::default()))
    }
}
