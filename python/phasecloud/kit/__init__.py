"""A kit for phasecloud propagators in Python: write a function, and let `serve` do the rest.

    from phasecloud.kit import SAMPLES, serve

    def propagate(problem, run):
        for time in problem.times:
            ...
            with run.snapshot(SAMPLES, rows=1000) as (phi, e):
                phi[:], e[:] = ...

    if __name__ == "__main__":
        serve(propagate)

The function is called once per scenario. `problem` says what to propagate; the columns from `run.snapshot` lie in the shared
memory in which the estimator reads them. The kit handles topics, handshake, CPU time, progress, errors, signals and the end.

iceoryx2 0.10 needs care in Python, which explains some code below that looks odd: a received payload's `len()` counts bytes, so lengths
come from `number_of_elements`; `delete()` and anything after it may abort the process, so samples are dropped instead; a
publisher that waits for a reader holds the interpreter's lock, so this kit discards the message and then raises an error.
"""

import ctypes
import os
import signal
import sys
import time
import traceback
from contextlib import contextmanager

import iceoryx2 as iox
import numpy as np

from . import layout
from .layout import CHARACTERISTICS, MIXTURE, SAMPLES  # noqa: F401, for propagators to import from here

LONGEST_SLEEP = iox.Duration.from_secs(1)


def serve(propagate):
    """Serves the run that started this process with `propagate(problem, run)` until the launcher ends it.

    Leaves the process with exit code 1 if anything fails, after telling the launcher.
    """
    try:
        Session(Signals()).serve(propagate)
    except Stopped:
        pass
    except Exception:
        traceback.print_exc()
        sys.stdout.flush()
        sys.stderr.flush()
        # Without closing the ports: a message of a publisher that closes is lost to a reader that has not yet connected to it. The
        # launcher frees the ports of a dead process once it has read why it ended.
        os._exit(1)


class Stopped(BaseException):
    """The process was asked to stop. Not an Exception, so that a propagator's `except Exception` lets it through."""


class Variable:
    """A variable in which orbits are given and read out."""

    def __init__(self, entry):
        self.name, self.symbol = _unpack(entry.name), _unpack(entry.symbol)  #: "solar angle", "phi"
        self.unit = _unpack(entry.unit)  #: "rad"; empty for a pure number
        self.is_circle = entry.range == layout.CIRCLE  #: an angle without a beginning
        self.bounds = (-np.inf, np.inf) if self.is_circle else (entry.low, entry.high)  #: values lie between them


class Problem:
    """What to propagate. Arrays are read-only views of shared memory: copy what you keep beyond the scenario."""

    def __init__(self, sample):
        header, numbers = sample.user_header().contents, _view(sample)
        self.run_id, self.scenario = header.run_id, header.scenario
        self.name = _unpack(header.name)
        self.model = _unpack(header.model)  #: the model's name: "planar"
        parameters = header.parameters[: header.parameter_count]
        self.parameters = {_unpack(entry.name): entry.value for entry in parameters}  #: those of the model, by name
        self.variables = [Variable(entry) for entry in header.variables[: header.variable_count]]
        #: which of the variables grows to its critical value when the satellite re-enters, and that value
        self.reentry, self.critical = header.reentry, header.critical
        #: what densities are compared in, each a list of pairs: position of a variable, bins of its axis
        self.projections = [_axes(entry) for entry in header.projections[: header.projection_count]]
        count, axes = len(self.variables), sum(map(len, self.projections))
        head, columns = count + count * (count + 1) // 2, 1 + 2 * axes
        if header.snapshots == 0 or numbers.size != head + header.snapshots * columns:
            raise ValueError(f"scenario: {numbers.size} numbers for {header.snapshots} snapshots")
        self.mean = numbers[:count]  #: mean of the initial Gaussian, which is cut to the variables' bounds
        self.covariance = np.zeros((count, count))  #: its covariance
        self.covariance[np.triu_indices(count)] = numbers[count:head]
        self.covariance[np.tril_indices(count)] = self.covariance.T[np.tril_indices(count)]
        rows = numbers[head:].reshape(-1, columns)
        self.times = rows[:, 0]  #: times of the snapshots [yr]
        self.grids = rows[:, 1:].reshape(-1, axes, 2)  #: lowest and highest value of each snapshot's axes, projection by projection
        #: times of a first-passage curve [yr]
        self.passage_times = np.linspace(0.0, float(self.times[-1]), layout.PASSAGE_TIMES)

    def require(self, *models):
        """Refuses the scenario if its model is none of these: its equations of motion are others."""
        if self.model not in models:
            raise ValueError(f"this propagator moves orbits of the model {' or '.join(models)}, not of {self.model}")


def _columns(kind, variables):
    """Number of columns of a snapshot of a cloud with so many variables: samples have a column for each, a mixture has weight, means and the upper
    triangle of the covariance, row by row."""
    if kind == SAMPLES:
        return variables
    return 1 + variables + variables * (variables + 1) // 2 if kind == MIXTURE else layout.COLUMNS[kind]


def _axes(entry):
    axes = [(entry.first, entry.first_bins), (entry.second, entry.second_bins)]
    return axes[: entry.dimensions]


class Run:
    """Sends the results of one scenario."""

    def __init__(self, session, problem):
        self._session, self._problem = session, problem
        self._total = 0
        self.outlet, self._reserved, self.sent = None, 0, 0
        self._passage = (np.empty((0, layout.PASSAGE_COLUMNS)), "this propagator does not compute first passages")
        self._passage_samples = (0, True)
        self._clock = time.process_time()

    def share(self, total):
        """The rows, as a range, that this process is to compute of the `total` rows that every snapshot of the case has.

        These are all rows, unless the launch file says `shards`: then several processes share the case, and a row must depend
        on its number alone. Call it before the first snapshot.
        """
        shard, shards = self._session.shard, self._session.shards
        if total < shards:
            raise ValueError(f"{total} rows are too few for {shards} shards")
        self._total = total
        return range(total * shard // shards, total * (shard + 1) // shards)

    def reserve(self, kind, rows):
        """Says before the first snapshot how many rows the largest snapshot has; needed only if the number of rows grows."""
        if self.outlet is not None:
            raise ValueError("reserve comes before the first snapshot")
        self._reserved = _columns(kind, len(self._problem.variables)) * rows
        self.outlet = Outlet(self._session, "phasecloud/snapshot", layout.SnapshotHeader, self._reserved)

    @contextmanager
    def snapshot(self, kind, rows, **fields):
        """The next snapshot: writable columns in shared memory, sent when the `with` block ends. Do not keep them.

        Samples have a column for each of `problem.variables`, in their order.

        `fields` are those that the kind has in layout.DETAILS: replicates of samples, treatment, resolution, lattice and
        degree of characteristics, disagreement of a mixture. Those that are left out are unset.
        """
        session, problem = self._session, self._problem
        if session.shards > 1 and not self._total:
            raise ValueError("this propagator cannot be split into shards: it does not call run.share")
        if self.sent == len(problem.times):
            raise ValueError(f"the scenario has only {self.sent} snapshots")
        details = layout.details(kind, fields)
        if self.outlet is None:
            self.reserve(kind, rows)
        columns = _columns(kind, len(problem.variables))
        if not 0 < rows * columns <= self._reserved:
            reserved = self._reserved // columns
            raise ValueError(f"{rows} rows, but there is room for {reserved}; call reserve before the first snapshot")
        session.signals.check_stop()
        draft = self.outlet.draft(rows * columns)
        yield _view(draft, writable=True).reshape(columns, rows)
        seconds = time.process_time() - self._clock
        if self.sent + 1 == len(problem.times):
            # Sent before the last snapshot, so that a reader that has this snapshot can have the passages, too.
            session.send_passage(problem, *self._passage, *self._passage_samples)
        header = layout.SnapshotHeader(
            run_id=problem.run_id,
            time=problem.times[self.sent],
            seconds=seconds,
            scenario=problem.scenario,
            index=self.sent,
            count=len(problem.times),
            kind=kind,
            rows=rows,
            columns=columns,
            attempt=session.attempt,
            total=self._total if session.shards > 1 else 0,
            shard=session.shard,
            shards=session.shards,
            most_rows=self._reserved // columns,
            label=_pack(session.label, 32),
            details=details,
        )
        self.outlet.send(draft, header)
        self.sent += 1
        session.report(layout.PROGRESS, problem.scenario, (self.sent, len(problem.times)))
        self._clock = time.process_time()

    def first_passages(self, probability, low=np.nan, high=np.nan, samples=0, independent=True):
        """The probability that e has ever reached its critical value by each of `problem.passage_times`, with interval.

        Optional; call it before the last snapshot. If the probability is counted from equally weighted samples of this process, `samples`
        is their number: the counts of shards are added up, and a curve without an interval gets Wilson's, unless the samples depend on one another
        (`independent=False`). Otherwise the curve of shard 0 is used.
        """
        self._passage_samples = (samples, independent)
        curve = np.empty((layout.PASSAGE_TIMES, layout.PASSAGE_COLUMNS))
        curve[:, 0], curve[:, 1], curve[:, 2], curve[:, 3] = self._problem.passage_times, probability, low, high
        self._passage = (curve, "")


class Session:
    """The access of the process to the run, its reports to the launcher, and its signals."""

    def __init__(self, signals):
        self.signals = signals
        self.label, self.run_id = _environment("LABEL"), int(_environment("RUN_ID"))
        self.attempt = int(os.environ.get("PHASECLOUD_ATTEMPT", 0))  # how often the launcher has restarted the process
        #: which shard of its case the process computes, and how many shards there are
        self.shard, self.shards = int(os.environ.get("PHASECLOUD_SHARD", 0)), int(os.environ.get("PHASECLOUD_SHARDS", 1))
        if os.environ.get("PHASECLOUD_REDUCE") == "1":
            raise OSError("this kit cannot reduce samples; leave out `reduce`")
        self.name = self.label if self.shards == 1 else f"{self.label}/{self.shard}"
        self.node = (
            iox.NodeBuilder.new()
            .name(iox.NodeName.new(self.name))
            .config(_config(_environment("ROOT"), _environment("PREFIX")))
            .signal_handling_mode(iox.SignalHandlingMode.Disabled)
            .create(iox.ServiceType.Ipc)
        )
        self._status = Outlet(self, "phasecloud/status", layout.StatusHeader, 2)
        passage_numbers = layout.PASSAGE_TIMES * layout.PASSAGE_COLUMNS
        self._passages = Outlet(self, "phasecloud/passage", layout.PassageHeader, passage_numbers)

    def serve(self, propagate):
        """Serves one scenario after another until Stopped is raised."""
        scenarios = Inlet(self, "phasecloud/scenario", layout.ScenarioHeader)
        self.report(layout.READY)
        outlet = None  # the outlet of the last scenario; its messages are lost when it is dropped
        newest = -1
        while True:
            while (sample := scenarios.receive()) is not None:
                if (scenario := sample.user_header().contents.scenario) <= newest:
                    continue  # published once more by a restarted scenario node
                newest = scenario
                outlet = None
                outlet = self._serve_one(propagate, sample)
                del sample
            # A reader that joins late, such as a recorder that was started again, must also get the earlier messages.
            ports = [scenarios, outlet, self._passages, self._status]
            self.signals.wait([port for port in ports if port])

    def _serve_one(self, propagate, sample):
        scenario = sample.user_header().contents.scenario
        try:
            problem = Problem(sample)
            run = Run(self, problem)
            propagate(problem, run)
            if run.sent < len(problem.times):
                raise ValueError(f"only {run.sent} of {len(problem.times)} snapshots were sent")
        except Exception as error:
            self.report(layout.FAILED, scenario, text=f"{type(error).__name__}: {error}")
            raise
        self.report(layout.DONE, scenario, (1, 1))
        return run.outlet

    def report(self, event, scenario=0, units=(0, 0), text=""):
        """Sends a report to the launcher."""
        label = _pack(self.label, 32)
        role, shard = (layout.CASE, 0) if self.shards == 1 else (layout.SHARD, self.shard)
        header = layout.StatusHeader(
            run_id=self.run_id, event=event, scenario=scenario, role=role, shard=shard, node=label, text=_pack(text, 1024)
        )
        if event == layout.FAILED:  # it is this process that cannot go on
            header.subject_role, header.subject_shard, header.subject = role, shard, label
        self._status.send_numbers(units, header)

    def send_passage(self, problem, curve, reason, samples, independent):
        """Sends the first-passage curve, or why there is none."""
        label, reason = _pack(self.label, 32), _pack(reason, 192)
        header = layout.PassageHeader(
            run_id=self.run_id,
            samples=samples,
            scenario=problem.scenario,
            rows=len(curve),
            shard=self.shard,
            shards=self.shards,
            dependent=int(not independent),
            label=label,
            reason=reason,
        )
        self._passages.send_numbers(curve, header)


class Outlet:
    """Sends messages on a topic. Messages that have not been read are lost when it is dropped."""

    def __init__(self, session, topic, header, most_numbers):
        self.topic = topic
        self._messages, events = _open(session.node, topic, header)
        self.listener = events.listener_builder().create()
        self._notifier = events.notifier_builder().create()
        self._publisher = (
            self._messages.publisher_builder()
            .initial_max_slice_len(most_numbers)
            .allocation_strategy(iox.AllocationStrategy.Static)
            .backpressure_strategy(iox.BackpressureStrategy.DiscardData)
            .max_loaned_samples(2)
            .create()
        )

    def draft(self, numbers):
        """Borrows memory for a message."""
        return self._publisher.loan_slice_uninit(numbers)

    def send(self, draft, header):
        """Sends a draft and wakes the readers. It is gone afterwards."""
        draft.user_header()[0] = header
        readers = self._messages.dynamic_config.number_of_subscribers
        reached = draft.assume_init().send()
        self._notifier.notify_with_custom_event_id(iox.EventId.new(layout.SENT))
        # A reader that has left meanwhile does not need the message.
        readers = min(readers, self._messages.dynamic_config.number_of_subscribers)
        if reached < readers:
            raise ConnectionError(f"{self.topic}: a message reached {reached} of {readers} readers, one's buffer is full")

    def send_numbers(self, numbers, header):
        """Copies numbers into a message and sends it."""
        numbers = np.asarray(numbers, dtype=float).ravel()
        draft = self.draft(numbers.size)
        _view(draft, writable=True)[:] = numbers
        self.send(draft, header)

    def attend(self):
        """Delivers what has been sent to readers that have joined since."""
        if any(event.id.as_value == layout.JOINED for event in self.listener.try_wait()):
            self._publisher.update_connections()
            self._notifier.notify_with_custom_event_id(iox.EventId.new(layout.SENT))


class Inlet:
    """Receives the messages of a topic."""

    def __init__(self, session, topic, header):
        messages, events = _open(session.node, topic, header)
        self.listener = events.listener_builder().create()
        self._subscriber = messages.subscriber_builder().create()
        self._notifier = events.notifier_builder().create()
        self._notifier.notify_with_custom_event_id(iox.EventId.new(layout.JOINED))

    def receive(self):
        """The next message, or None."""
        return self._subscriber.receive()

    def attend(self):
        """Drops the events: they only wake the process, the messages wait in their buffer."""
        self.listener.try_wait()


class Signals:
    """SIGTERM and SIGINT, and the end of the launcher: each raises Stopped, also in the middle of a computation."""

    def __init__(self):
        self._stopping = False
        self._pipe = os.pipe2(os.O_NONBLOCK | os.O_CLOEXEC)
        signal.set_wakeup_fd(self._pipe[1], warn_on_full_buffer=False)
        for number in (signal.SIGTERM, signal.SIGINT):
            signal.signal(number, self._stop)
        self._launcher = int(os.environ.get("PHASECLOUD_LAUNCHER", 0))
        if self._launcher:
            set_parent_death_signal = 1
            ctypes.CDLL(None).prctl(set_parent_death_signal, signal.SIGTERM, 0, 0, 0)
        self.check_stop()

    def _stop(self, *_):
        if not self._stopping:
            self._stopping = True
            raise Stopped

    def check_stop(self):
        """Raises Stopped if the process has been asked to stop or the launcher is gone."""
        if self._stopping or (self._launcher and not os.path.exists(f"/proc/{self._launcher}")):
            self._stopping = True
            raise Stopped

    def wait(self, ports):
        """Sleeps until something arrives on one of the ports, or a while has passed."""
        disabled = iox.SignalHandlingMode.Disabled
        waits = iox.WaitSetBuilder.new().signal_handling_mode(disabled).create(iox.ServiceType.Ipc)
        wakeup = iox.FileDescriptor.non_owning_new(self._pipe[0])
        guards = [waits.attach_notification_fd(wakeup)]
        guards += [waits.attach_notification(port.listener) for port in ports]
        self.check_stop()
        waits.wait_and_process_with_timeout(LONGEST_SLEEP)
        del guards
        for port in ports:
            port.attend()
        self.check_stop()


def _environment(name):
    value = os.environ.get(f"PHASECLOUD_{name}")
    if value is None:
        raise OSError(f"PHASECLOUD_{name} is not set; the launcher of a run sets it")
    return value


def _config(root, prefix):
    """The run's domain. Only the launcher cleans up after dead nodes."""
    config = iox.config.default()
    config.global_cfg.root_path = iox.Path.new(root)
    config.global_cfg.prefix = iox.FileName.new(prefix)
    config.global_cfg.node.cleanup_dead_nodes_on_creation = False
    config.global_cfg.node.cleanup_dead_nodes_on_destruction = False
    config.global_cfg.service.cleanup_dead_nodes_on_open = False
    return config


def _open(node, topic, header):
    """Both services of a topic, which the launcher has created."""
    name = iox.ServiceName.new(topic)
    numbers = iox.Slice[ctypes.c_double]
    messages = node.service_builder(name).publish_subscribe(numbers).user_header(header).open()
    return messages, node.service_builder(name).event().open()


def _view(sample, writable=False):
    """A sample's payload without a copy; the view keeps the sample."""
    buffer = (ctypes.c_double * sample.header.number_of_elements).from_address(sample.payload_ptr)
    buffer._sample = sample
    view = np.frombuffer(buffer)
    view.flags.writeable = writable
    return view


def _pack(text, size):
    """Text as NUL-padded UTF-8, cut between characters."""
    data = text.encode("utf-8", "replace")[:size].decode("utf-8", "ignore").encode()
    return (ctypes.c_uint8 * size)(*data)


def _unpack(field):
    return bytes(field).split(b"\0")[0].decode("utf-8", "replace")
