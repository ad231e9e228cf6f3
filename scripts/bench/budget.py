"""CPU seconds, and samples that fit into them: for scripts that render inside the Pythons of other renderers too."""
import resource

FIRST = 4  # samples
CLOSE = 0.03


def cpu_seconds():
    """User and system time of this process, all threads, since it began."""
    used = resource.getrusage(resource.RUSAGE_SELF)
    return used.ru_utime + used.ru_stime


def samples_for(seconds, took, tries=4):
    """The samples that take these CPU seconds; took(samples) renders and returns its own."""
    points, samples = [(0, 0.0)], FIRST
    for _ in range(tries):
        points.append((samples, took(samples)))
        (few, before), (many, after) = points[-2:]
        each = (after - before) / (many - few)
        following = max(round(many + (seconds - after) / each), 1) if each > 0.0 else 2 * many
        if abs(after - seconds) < CLOSE * seconds or following == samples:
            break
        samples = min(following, 8 * many)
    return min(points[1:], key=lambda point: abs(point[1] - seconds))[0]


def sequence(job, render):
    """What a job asks for, by render(frame, samples, seed, path), which may tell its CPU seconds; a path of None keeps no picture. Start-up is what the first frame of
    one sample took, with loading; samples are given, or fit into "seconds" of the frame in the middle; "runs" are of all frames."""
    def took(frame, samples, seed, path=None):
        begin = cpu_seconds()
        told = render(frame, samples, seed, path)
        return cpu_seconds() - begin if told is None else told

    frames = job["frames"]
    took(frames[0], 1, 1)
    startup, middle = cpu_seconds(), frames[len(frames) // 2]
    samples = job.get("samples") or samples_for(job["seconds"], lambda n: took(middle, n, 1))
    cpu = [sum(took(f, samples, 1000 * run["seed"] + f, run["pattern"].replace("####", "%04d" % f)) for f in frames) for run in job["runs"]]
    return {"startup": startup, "samples": samples, "cpu": cpu}
