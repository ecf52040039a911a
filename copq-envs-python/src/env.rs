//! The environment: requests to its worker.

use std::path::{Path, PathBuf};
use std::time::Duration;

use copq::error::check_len;
use copq::{Env, EnvSpec, Error, Outcome, Result};
use serde::Serialize;

use crate::Options;
use crate::hello::Hello;
use crate::worker::{Failure, Worker};

/// The packages that environments come from: the part of a task's name before the colon.
pub const PACKAGES: [&str; 3] = ["gymnasium", "mo-gymnasium", "safety-gymnasium"];
/// One more than the largest seed that every package accepts.
const SEEDS: u64 = 1 << 31;
/// The longest timeout (s).
const LONGEST: f64 = 1e6;

/// A Python environment in its own process.
///
/// Observations and actions are flat, and are passed as f32. A seed's episode is the one that
/// `reset(seed=seed % 2**31)` starts in Python. The environment never resets itself, so the
/// observation at a time limit is the episode's own last one. It cannot be saved in mid-episode.
/// Python's and NumPy's own generators start the same in every process, so an environment that is
/// built at random is always the same. A unique port or file name has to come from elsewhere
/// (`random.SystemRandom`).
///
/// An exception in Python is an error here; the next [`Env::reset`] continues. After the process
/// has died, or has been given up because it was silent, the next reset starts a new one.
///
/// ```no_run
/// use copq::Env;
/// use copq_envs_python::{Options, PythonEnv};
///
/// let options = Options { kwargs: r#"{"g": 9.81}"#.to_owned(), ..Options::default() };
/// let mut env = PythonEnv::new("gymnasium:Pendulum-v1", &options)?;
/// assert_eq!(env.spec().horizon, 200);
/// env.reset(0, &mut [0.0; 3])?;
/// # Ok::<(), copq::Error>(())
/// ```
pub struct PythonEnv {
    python: PathBuf,
    /// The worker's settings, as JSON.
    settings: String,
    timeout: Duration,
    spec: EnvSpec,
    hello: Hello,
    worker: Option<Worker>,
    request: Vec<u8>,
    answer: Vec<u8>,
    /// Steps of the episode so far.
    length: u64,
}

impl std::fmt::Debug for PythonEnv {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("PythonEnv")
            .field("python", &self.python)
            .field("settings", &self.settings)
            .finish_non_exhaustive()
    }
}

/// The settings of a worker.
#[derive(Serialize)]
struct Settings<'a> {
    package: &'a str,
    id: &'a str,
    kwargs: serde_json::Map<String, serde_json::Value>,
    imports: &'a [String],
    render: bool,
}

/// A picture of an environment at one moment, as it draws itself.
///
/// ```no_run
/// use copq::Env;
/// use copq_envs_python::{Options, PythonEnv};
///
/// let options = Options { render: true, ..Options::default() };
/// let mut env = PythonEnv::new("gymnasium:Pendulum-v1", &options)?;
/// env.reset(0, &mut [0.0; 3])?;
/// let picture = env.picture()?;
/// assert_eq!(picture.rgb.len(), 3 * picture.width as usize * picture.height as usize);
/// # Ok::<(), copq::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    /// Pixels from left to right.
    pub width: u32,
    /// Pixels from top to bottom.
    pub height: u32,
    /// Red, green and blue of every pixel, row by row from the top.
    pub rgb: Vec<u8>,
}

impl PythonEnv {
    /// Starts the environment of a task such as `gymnasium:Pendulum-v1`.
    pub fn new(task: &str, options: &Options) -> Result<Self> {
        let options = &options.clone().with_usual_limit(task);
        let python = crate::interpreter(options.python.as_deref());
        let settings = settings(task, options)?;
        let timeout = timeout(options.timeout)?;
        let (worker, hello) = start(task, &python, &settings, timeout)?;
        let spec = hello.spec(task, options)?;
        Ok(Self {
            python,
            settings,
            timeout,
            hello,
            request: Vec::new(),
            answer: vec![0; 4 * (spec.obs_len + spec.objectives.len())],
            spec,
            worker: Some(worker),
            length: 0,
        })
    }

    /// How many pictures per second make a film of it in real time.
    pub fn frames_per_second(&self) -> f64 {
        self.hello.frames_per_second
    }

    /// What it looks like now. It must have been made with [`Options::render`].
    pub fn picture(&mut self) -> Result<Picture> {
        let mut size = [0; 8];
        self.request = b"p".to_vec();
        self.ask(&mut size, "render")?;
        let [height, width] =
            [0, 4].map(|at| u32::from_le_bytes([0, 1, 2, 3].map(|i| size[at + i])));
        let mut rgb = vec![0; 3 * height as usize * width as usize];
        let worker = self.worker.as_mut().map(|worker| worker.read(&mut rgb, "render"));
        self.answered(worker.unwrap_or(Ok(())))?;
        Ok(Picture { width, height, rgb })
    }

    /// Sends the request, writes the answer's bytes into `answer` and returns its status.
    fn ask(&mut self, answer: &mut [u8], doing: &str) -> Result<u8> {
        let Some(worker) = &mut self.worker else {
            return Err(
                self.failed("wanted a running episode (call Env::reset), got none".to_owned())
            );
        };
        let asked = worker.ask(&self.request, answer, doing);
        self.answered(asked)
    }

    /// Passes on an answer; a lost worker is dropped, and its episode with it.
    fn answered<T>(&mut self, answer: Result<T, Failure>) -> Result<T> {
        answer.map_err(|failure| match failure {
            Failure::Raised(text) => self.failed(text),
            Failure::Lost(text) => {
                self.worker = None;
                self.failed(text)
            }
        })
    }

    /// Converts the bytes of an answer to numbers; an error for the first that is not finite.
    fn take(&self, from: &[u8], into: &mut [f32], what: &str) -> Result<()> {
        let (bytes, _) = from.as_chunks::<4>();
        for (i, (number, bytes)) in into.iter_mut().zip(bytes).enumerate() {
            *number = f32::from_le_bytes(*bytes);
            if !number.is_finite() {
                let when = self.length;
                let text = format!(
                    "number {i} of its {what} after step {when}: wanted a finite number that fits \
                     f32, got {number}"
                );
                return Err(self.failed(text));
            }
        }
        Ok(())
    }

    fn failed(&self, what: String) -> Error {
        Error::Env { env: self.spec.name.clone(), what }
    }

    /// Starts a worker for the same environment, in place of one that was lost.
    fn restart(&mut self) -> Result<()> {
        let (worker, hello) = start(&self.spec.name, &self.python, &self.settings, self.timeout)?;
        if hello != self.hello {
            return Err(self.failed("its new process has a different environment".to_owned()));
        }
        self.worker = Some(worker);
        Ok(())
    }
}

impl Env for PythonEnv {
    fn spec(&self) -> &EnvSpec {
        &self.spec
    }

    fn reset(&mut self, seed: u64, obs: &mut [f32]) -> Result<()> {
        check_len("observation", obs.len(), self.spec.obs_len)?;
        if self.worker.is_none() {
            self.restart()?;
        }
        self.length = 0;
        self.request.clear();
        self.request.push(b'r');
        self.request.extend((seed % SEEDS).to_le_bytes());
        let mut answer = std::mem::take(&mut self.answer);
        let asked = self.ask(&mut answer[..4 * obs.len()], "reset");
        let taken = asked.and_then(|_| self.take(&answer, obs, "observation"));
        self.answer = answer;
        taken
    }

    fn step(&mut self, action: &[f32], obs: &mut [f32], reward: &mut [f32]) -> Result<Outcome> {
        check_len("action", action.len(), self.spec.action_len())?;
        check_len("observation", obs.len(), self.spec.obs_len)?;
        check_len("reward", reward.len(), self.spec.objectives.len())?;
        self.request.clear();
        self.request.push(b's');
        action.iter().for_each(|number| self.request.extend(number.to_le_bytes()));
        let mut answer = std::mem::take(&mut self.answer);
        let asked = self.ask(&mut answer, "step");
        self.length += 1;
        let (first, second) = answer.split_at(4 * obs.len());
        let taken = asked.and_then(|status| {
            self.take(first, obs, "observation")?;
            self.take(second, reward, "reward")?;
            Ok(status)
        });
        self.answer = answer;
        match taken? {
            0 => Ok(Outcome::Running),
            1 => Ok(Outcome::Terminated),
            2 => Ok(Outcome::Truncated),
            other => {
                // A worker that wrote this can no longer be trusted.
                self.worker = None;
                Err(self.failed(format!("wanted a status from 0 to 2, got {other}")))
            }
        }
    }
}

fn start(task: &str, python: &Path, settings: &str, timeout: Duration) -> Result<(Worker, Hello)> {
    let failed = |what| Error::Env { env: task.to_owned(), what };
    Worker::start(python, settings, timeout).map_err(failed)
}

/// The settings of a task's worker.
fn settings(task: &str, options: &Options) -> Result<String> {
    let (package, id) = parts(task).ok_or_else(|| {
        let wanted = format!("PACKAGE:ID, with PACKAGE one of {}", PACKAGES.join(", "));
        Error::invalid("Python task", wanted, task)
    })?;
    let kwargs = serde_json::from_str(&options.kwargs).map_err(|e| {
        let wanted = r#"a JSON object, such as {"max_episode_steps": 500}"#;
        Error::invalid(
            "arguments of the environment",
            wanted,
            format!("'{}' ({e})", options.kwargs),
        )
    })?;
    let Options { imports, render, .. } = options;
    serde_json::to_string(&Settings { package, id, kwargs, imports, render: *render })
        .map_err(|e| Error::other("settings of the environment", e))
}

/// The package and the environment's name in it, if it is a Python task.
pub(crate) fn parts(task: &str) -> Option<(&str, &str)> {
    task.split_once(':').filter(|(package, id)| PACKAGES.contains(package) && !id.is_empty())
}

fn timeout(seconds: f64) -> Result<Duration> {
    if seconds > 0.0 && seconds <= LONGEST {
        return Ok(Duration::from_secs_f64(seconds));
    }
    Err(Error::invalid(
        "timeout of the environment",
        format!("more than 0 s and at most {LONGEST} s"),
        seconds,
    ))
}
