#!/usr/bin/env python3
"""scripts/slurm-render against a real Slurm: munged, slurmctld and two slurmd of Debian, started here for the test.

    test_slurm.py PROGRAM SCENE CAMERA

The daemons run as this user in a folder of their own, on free ports, and see no other configuration. Without the packages
slurmctld, slurmd, slurm-client and munge the tests are skipped.
"""
import json
import os
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
import unittest

PROGRAM, SCENE, CAMERA = sys.argv[1:4] if len(sys.argv) > 3 else (None, None, None)
TOP = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
SCRIPT = os.path.join(TOP, "scripts", "slurm-render")
NEEDED = ("munged", "slurmctld", "slurmd", "sbatch", "scontrol")
# a task takes seconds, so that it can be killed on the way
SPP = "480"
SHOT = ["--camera", CAMERA, "--size", "32x18", "--spp", SPP, "--group", "1", "--frames", "1-16", "--threads", "1"]
PATIENCE = 240.0  # against hanging alone: a machine may be busy

CONFIGURATION = """
ClusterName=reframe
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={port}
AuthType=auth/munge
AuthInfo=socket={folder}/munge/socket,cred_expire=5
CredType=cred/munge
SlurmUser={user}
SlurmdUser={user}
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool-%n
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd-%n.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd-%n.log
ProctrackType=proctrack/pgid
TaskPlugin=task/none
SwitchType=switch/none
MpiDefault=none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
SelectType=select/linear
SchedulerType=sched/builtin
SchedulerParameters=sched_interval=1
ReturnToService=2
KillWait=5
NodeName=n1 NodeHostname={host} NodeAddr=127.0.0.1 Port={first} CPUs=1
NodeName=n2 NodeHostname={host} NodeAddr=127.0.0.1 Port={second} CPUs=1
PartitionName=main Nodes=n1,n2 Default=YES MaxTime=INFINITE State=UP
"""


def find(name):
    return shutil.which(name, path=os.environ.get("PATH", "") + ":/usr/sbin:/sbin")


def free_ports(count):
    held = [socket.socket() for _ in range(count)]
    for place in held:
        place.bind(("127.0.0.1", 0))
    ports = [place.getsockname()[1] for place in held]
    for place in held:
        place.close()
    return ports


def until(condition, what, seconds=PATIENCE):
    end = time.monotonic() + seconds
    while True:
        found = condition()
        if found:
            return found
        if time.monotonic() > end:
            raise AssertionError("not in %g s: %s" % (seconds, what))
        time.sleep(0.1)


class Cluster:
    def __init__(self):
        self.folder = tempfile.mkdtemp(prefix="reframe-slurm-", dir="/tmp")  # short: the path of a socket has a limit
        self.daemons = []
        for name in ("munge", "state"):
            os.mkdir(os.path.join(self.folder, name), 0o700)
        port, first, second = free_ports(3)
        with open(os.path.join(self.folder, "slurm.conf"), "w") as file:
            file.write(CONFIGURATION.format(host=socket.gethostname().split(".")[0], port=port, first=first, second=second,
                                            folder=self.folder, user=subprocess.check_output(["id", "-un"], text=True).strip()))
        # slurmd of Debian 13 ends where it may not use control groups
        version = subprocess.check_output([find("slurmctld"), "-V"], text=True).split()[-1]
        if int(version.split(".")[0]) >= 24:
            with open(os.path.join(self.folder, "cgroup.conf"), "w") as file:
                file.write("CgroupPlugin=disabled\n")
        os.environ["SLURM_CONF"] = os.path.join(self.folder, "slurm.conf")

    def start_daemon(self, *words):
        log = open(os.path.join(self.folder, "daemons.log"), "ab")
        self.daemons.append(subprocess.Popen([find(words[0]), *words[1:]], stdout=log, stderr=log, stdin=subprocess.DEVNULL,
                                             start_new_session=True))
        log.close()

    def start(self):
        munge = os.path.join(self.folder, "munge")
        with open(os.path.join(munge, "key"), "wb") as file:
            file.write(os.urandom(1024))
        os.chmod(os.path.join(munge, "key"), 0o400)
        self.start_daemon("munged", "--foreground", "--force", "--key-file=" + munge + "/key", "--socket=" + munge + "/socket",
                          "--pid-file=" + munge + "/pid", "--log-file=" + munge + "/log", "--seed-file=" + munge + "/seed")
        until(lambda: os.path.exists(munge + "/socket"), "munged listens")
        self.start_daemon("slurmctld", "-D")
        for node in ("n1", "n2"):
            self.start_daemon("slurmd", "-D", "-N", node)
        until(lambda: subprocess.run(["sinfo", "-h", "-o", "%T %D"], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
                                     text=True).stdout.strip() == "idle 2", "two nodes are idle")

    def stop(self):
        subprocess.run(["scancel", "--partition=main"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        time.sleep(0.5)
        for daemon in reversed(self.daemons):
            daemon.terminate()
        for daemon in self.daemons:
            try:
                daemon.wait(10)
            except subprocess.TimeoutExpired:
                daemon.kill()
                daemon.wait()

    def logs(self):
        words = []
        for name in sorted(os.listdir(self.folder)):
            if name.endswith(".log"):
                with open(os.path.join(self.folder, name), errors="replace") as file:
                    words.append("== %s\n%s" % (name, file.read()[-3000:]))
        return "\n".join(words)


def read(path):
    with open(path, "rb") as file:
        return file.read()


def frames(folder):
    return {name: read(os.path.join(folder, name)) for name in os.listdir(folder) if name.endswith(".exr")}


class SlurmRender(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.cluster = Cluster()
        try:
            cls.cluster.start()
        except AssertionError:
            print(cls.cluster.logs())
            cls.tearDownClass()
            raise
        cls.right = {}
        folder = os.path.join(cls.cluster.folder, "right")
        subprocess.run([PROGRAM, "render", SCENE, *SHOT, "-o", folder + "/f.####.exr", "--quiet"], check=True,
                       stdout=subprocess.DEVNULL)
        cls.right = frames(folder)
        assert len(cls.right) == 16

    @classmethod
    def tearDownClass(cls):
        cls.cluster.stop()
        shutil.rmtree(cls.cluster.folder, ignore_errors=True)

    def slurm_render(self, name, *more, spp=SPP):
        self.folder = os.path.join(self.cluster.folder, name)
        shot = [spp if word == SPP else word for word in SHOT]
        return subprocess.run([SCRIPT, SCENE, *shot, "-o", self.folder + "/f.####.exr", "--nodes", "2", "--binary", PROGRAM, *more],
                              stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, timeout=PATIENCE)

    def job(self):
        with open(os.path.join(self.folder, "slurm", "job.json")) as file:
            return json.load(file)

    def finished(self):
        return sum(name.endswith(".exr") for name in os.listdir(self.folder))

    def log(self, name):
        return read(os.path.join(self.folder, "slurm", name)).decode()

    # the program of a task of ours, by the folder in its command line
    def processes(self, task):
        found = []
        for entry in filter(str.isdigit, os.listdir("/proc")):
            try:
                words = read("/proc/%s/cmdline" % entry).decode(errors="replace").split("\0")
            except OSError:
                continue
            if words[0] == PROGRAM and any(self.folder + "/slurm/task-1-%d.json" % task == word for word in words):
                found.append(int(entry))
        return found

    def test_a_killed_and_a_requeued_task_go_on_to_the_same_bytes(self):
        done = self.slurm_render("killed")
        self.assertEqual(done.returncode, 0, done.stderr)
        job = self.job()
        self.assertEqual([r["frames"] for r in job["nodes"]["ranges"]], ["1-8", "9-16"])
        until(lambda: self.finished() >= 2 and self.processes(0), "two frames are finished, task 0 runs")
        victims = self.processes(0)
        self.assertTrue(victims, "task 0 runs")
        os.kill(victims[0], signal.SIGKILL)  # as the system does where memory runs out
        subprocess.run(["scontrol", "requeue", job["array"] + "_1"], check=True)
        self.report_of_a_running_render()
        until(lambda: self.job()["state"] != "running", "the render ends")
        self.assertEqual(self.job()["state"], "complete", self.cluster.logs())
        self.assertEqual(frames(self.folder), self.right, "other frames than those of one machine")
        self.assertEqual(self.job()["round"], 2, "what the killed task left is submitted again")
        self.assertIn("start 2: frames 9-16", self.log("task-1-1.log"))
        self.assertIn("interrupted", self.log("task-1-1.log"))
        self.assertIn("complete: 16 frames", self.log("check.log"))

    def report_of_a_running_render(self):
        page = os.path.join(self.cluster.folder, "page.html")
        done = subprocess.run([PROGRAM, "report", self.folder, "-o", page, "--overwrite", "--json", "-", "--quiet"],
                              stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn(json.loads(done.stdout)["sequences"][0]["frames"], range(1, 16))

    def test_wait_returns_when_all_is_there_and_again_submits_nothing(self):
        done = self.slurm_render("waited", "--wait")
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertEqual(frames(self.folder), self.right)
        again = self.slurm_render("waited")
        self.assertEqual((again.returncode, again.stdout.strip()), (0, "complete: 16 frames, nothing to submit"))
        other = self.slurm_render("waited", spp="483")
        self.assertEqual(other.returncode, 1)
        self.assertIn("of another render", other.stderr)

    def test_a_damaged_frame_is_rendered_again(self):
        done = self.slurm_render("100%a", "--wait")
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertIn("complete: 16 frames", self.log("check.log"))  # sbatch expands % in names of logs
        self.log("task-1-0.log")
        with open(os.path.join(self.folder, "f.0003.exr"), "r+b") as file:
            file.truncate(os.path.getsize(file.name) - 20)
        done = self.slurm_render("100%a", "--wait")
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertEqual(frames(self.folder), self.right)
        self.assertEqual(self.job()["round"], 2)

    def test_group_and_tile_are_settled_once(self):
        self.folder = os.path.join(self.cluster.folder, "auto")
        shot = ["25" if word == SPP else "auto" if before == "--group" else word for before, word in zip([None] + SHOT, SHOT)]
        words = [SCRIPT, SCENE, *shot, "-o", self.folder + "/f.####.exr", "--nodes", "2", "--binary",
                 PROGRAM]
        done = subprocess.run([*words, "--wait"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, timeout=PATIENCE)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        job = self.job()
        self.assertEqual(job["settled"][::2], ["--group", "--tile", "--adaptive"])
        # as a machine of other memory would have settled them: what was settled first holds
        job["settled"][1] = "0"
        with open(os.path.join(self.folder, "slurm", "job.json"), "w") as file:
            json.dump(job, file)
        done = subprocess.run(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, timeout=PATIENCE)
        self.assertEqual(done.returncode, 1, done.stdout)
        self.assertIn("of another render", done.stderr)

    def test_a_render_that_cannot_go_on_gives_up_and_a_cancelled_one_stays_cancelled(self):
        done = self.slurm_render("hopeless", "--memory", "1M", "--wait")
        self.assertEqual(done.returncode, 1, done.stdout)
        self.assertIn("memory", done.stderr)
        done = self.slurm_render("cancelled", spp="30000")
        self.assertEqual(done.returncode, 0, done.stderr)
        until(lambda: self.processes(0) or self.processes(1), "a task runs")
        again = self.slurm_render("cancelled", spp="30000")
        self.assertIn("scancel them first", again.stderr)
        subprocess.run(["scancel", self.job()["array"]], check=True)
        until(lambda: self.job()["state"] != "running", "the check ends")
        self.assertIn("cancelled", self.job()["state"])


if __name__ == "__main__":
    if PROGRAM is None:
        sys.exit(__doc__)
    if not all(map(find, NEEDED)):
        print("skipped: no Slurm: scripts/install-packages slurmctld slurmd slurm-client munge")
        sys.exit(77)
    unittest.main(argv=sys.argv[:1])
