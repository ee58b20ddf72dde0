//! Work releases the interpreter's lock, and ends cleanly when it is interrupted.

use crate::interpreter::{capture, interpreter};

/// Counts in a second thread while a fit runs. Without the lock it counts on; with it, it would stand still until the fit's end.
const BESIDE: &str = "
import sys, threading, time, gonio
counted, stop = [], threading.Event()
def count():
    while not stop.is_set():
        counted.append(time.perf_counter())
        time.sleep(0.005)
capture = gonio.load(sys.argv[1])
thread = threading.Thread(target=count)
thread.start()
begin = time.perf_counter()
capture.fit(samples=8)
end = time.perf_counter()
stop.set()
thread.join()
during = sum(begin < moment < end for moment in counted)
# A thousand in five seconds, on a machine that does nothing else.
assert during >= 10, (during, end - begin)
";

#[test]
fn a_second_thread_runs_while_a_fit_runs() {
    let Some(python) = interpreter() else { return };
    let at = tempfile::tempdir().unwrap();
    python.succeeds(at.path(), BESIDE, &[capture("none-201").to_str().unwrap()]);
}

/// Sends itself SIGINT once a long render, or a long sweep, is under way; then works on.
#[cfg(unix)]
const INTERRUPTED: &str = "
import os, pathlib, signal, sys, threading, gonio
capture = gonio.load(sys.argv[1])
def interrupted(work):
    timer = threading.Timer(1.0, lambda: os.kill(os.getpid(), signal.SIGINT))
    timer.start()
    try:
        work()
    except KeyboardInterrupt:
        return True
    finally:
        timer.cancel()
    return False
assert interrupted(lambda: capture.render(samples=60000))
text = f'format = 1\\ncapture = {sys.argv[1]!r}\\nsamples = 60000\\n'
pathlib.Path('sweep.toml').write_text(text)
assert interrupted(lambda: list(gonio.sweep('sweep.toml')))
def stop(line):
    raise RuntimeError('enough: ' + line)
try:
    capture.fit(samples=4096, progress=stop)
except RuntimeError as error:
    print(error)
assert capture.render('00', samples=2).shape == (120, 160, 3)
";

#[cfg(unix)]
#[test]
fn control_c_and_a_callables_exception_end_the_work() {
    let Some(python) = interpreter() else { return };
    let at = tempfile::tempdir().unwrap();
    let text = python.succeeds(at.path(), INTERRUPTED, &[capture("none-201").to_str().unwrap()]);
    assert!(text.starts_with("enough: "), "{text}");
}
