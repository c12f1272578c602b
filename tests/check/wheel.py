"""What tests/check/wheel.sh asks of an installed wheel; the first argument says which.

notebooks NAME...   runs notebooks of volumes/notebooks and fails where a cell does
arrays FOGBOW       arrays beside the EXR of the command, read by OpenEXR; errors; Ctrl-C
memory              peak memory of a large picture, with and without all of its arrays
time FOGBOW [N]     processor time of renders beside those of the program FOGBOW, of N ratios
beside NAME         bpy or mitsuba in one process, imported before fogbow and after it
"""

import math
import os
import pathlib
import signal
import statistics
import subprocess
import sys
import tempfile
import threading
import time

VOLUMES = pathlib.Path(__file__).resolve().parents[2] / "volumes"
SMOKE = VOLUMES / "smoke.toml"


def notebooks(*names: str) -> None:
    import nbclient
    import nbformat

    for name in names:
        start = time.monotonic()
        book = nbformat.read(VOLUMES / "notebooks" / f"{name}.ipynb", as_version=4)
        folder = {"metadata": {"path": str(VOLUMES / "notebooks")}}
        nbclient.NotebookClient(book, timeout=600, kernel_name="python3", resources=folder).execute()
        print(f"{name}: runs in {time.monotonic() - start:.1f} s")


def arrays(program: str) -> None:
    import numpy as np
    import OpenEXR

    import fogbow

    settings = {"rays": 2, "photons": 20_000, "size": (96, 64), "seed": 3}
    flags = ["--rays=2", "--photons=20000", "--size=96x64", "--seed=3", "--quiet"]
    with tempfile.TemporaryDirectory() as folder:
        by_program, by_module = f"{folder}/program.exr", f"{folder}/module.exr"
        subprocess.run([program, "render", SMOKE, "-o", by_program, *flags], check=True, stdout=subprocess.DEVNULL)
        image = fogbow.render(SMOKE, **settings)
        image.save(by_module, f"{folder}/module.png")
        for ending in (".exr", ".png"):
            read = [pathlib.Path(path).with_suffix(ending).read_bytes() for path in (by_program, by_module)]
            assert read[0] == read[1], f"files in {ending} differ"
        file = OpenEXR.File(by_program, separate_channels=True)
        channels = file.channels()
        told = "fogbow:constant."
        constant = {name.removeprefix(told): value for name, value in file.header().items() if name.startswith(told)}
        assert channels.keys() | constant.keys() == image.layers.keys(), (channels.keys(), constant.keys())
        for name, values in image.layers.items():
            read = channels[name].pixels if name in channels else np.full_like(values, constant[name])
            assert values.dtype == np.float32 and np.array_equal(values, read), name
        for number, name in enumerate("RGB"):
            assert np.array_equal(image.rgb[..., number], channels[name].pixels), name
            assert np.shares_memory(image.rgb, image.layers[name]), f"{name} was copied"
        assert not image.rgb.flags.owndata and not image.rgb.flags.writeable
        assert image._repr_png_() == pathlib.Path(f"{folder}/module.png").read_bytes()
        printed = subprocess.run([program, "error", by_program, by_program], check=True, capture_output=True).stdout
        assert printed and fogbow.error(by_program, image)["mse"] == 0.0
    print("arrays, files and views agree with the command and with OpenEXR")

    # Photons that pictures share.
    scene = fogbow.load(SMOKE)
    ways = [settings, {**settings, "director": "x"}, {**settings, "exposure": 1}, {**settings, "rays": 3}]
    for way, image in zip(ways, scene.render_all(ways)):
        alone = fogbow.render(SMOKE, **way)
        assert all(np.array_equal(alone.layers[name], values) for name, values in image.layers.items()), way
        assert ("shared photons" in image.seconds) == (way["rays"] == 2), way
    print("pictures of a list have the pixels of each alone")

    # A volume's density is where it was put.
    density = np.zeros((20, 12, 9), np.float64)
    density[3, 4, 5] = 2.5
    volume = fogbow.volume(density, voxel_size=(0.1, 0.2, 0.3), origin=(1, 2, 3))
    (grid,) = fogbow.info(volume)["grids"]
    bounds = np.array(grid["world_bounds"])
    assert np.allclose(bounds, [[1.3, 2.8, 4.5]] * 2), bounds
    assert grid["statistics"]["max"] == 2.5 and grid["statistics"]["active"] == 1, grid
    picture = fogbow.render(fogbow.volume(np.ones((8, 8, 8)), voxel_size=0.1), rays=1, photons=1000, size=(16, 16))
    assert picture.rgb.max() > 0 and 0 < picture.alpha.max() <= 1
    assert set(fogbow.maps(SMOKE, size=(32, 32))) >= {"x", "z", "saliency", "xs"}
    assert fogbow.plan(SMOKE, size=(32, 32), photons=2000)["rays"] == 32

    wrong = {
        "ray=8": (fogbow.SettingError, lambda: fogbow.render(SMOKE, ray=8), "did you mean rays?"),
        "rays=0": (ValueError, lambda: fogbow.render(SMOKE, rays=0), "1 to 1048576"),
        "no file": (OSError, lambda: fogbow.render("none.toml"), "none.toml: cannot be read"),
        "dict": (fogbow.Error, lambda: fogbow.render({"camera": {"positio": [0, 0, 0]}}), "position"),
        "shape": (ValueError, lambda: fogbow.volume(np.ones((3, 3))), "three axes"),
    }
    for name, (kind, call, part) in wrong.items():
        try:
            call()
        except kind as error:
            assert part in str(error), f"{name}: {error}"
            print(f"{name}: {error}")
        else:
            raise AssertionError(f"{name} passed")
    interrupt()


def interrupt() -> None:
    """Ctrl-C ends a render while photons are shot and while rays are, and other threads run meanwhile."""
    import fogbow

    # A shell that starts this in the background has it ignore the signal.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    for stage, settings in {"photons": {"photons": 10_000_000}, "rays": {"rays": 100_000, "photons": 1000}}.items():
        begun, ticks = threading.Event(), []

        def told(name: str, done: int, total: int) -> None:
            if done > 0 and not begun.is_set() and (name == "photons") == (stage == "photons"):
                begun.set()
                threading.Timer(0.2, os.kill, (os.getpid(), signal.SIGINT)).start()
                threading.Thread(target=lambda: ticks.extend(sum(range(1000)) for _ in range(100))).start()

        try:
            fogbow.render(SMOKE, progress=told, size=(256, 256), **settings)
            raise AssertionError("the render was not interrupted")
        except KeyboardInterrupt:
            assert begun.is_set() and len(ticks) == 100
            print(f"Ctrl-C ends a render in its {stage}")


def child(*words: str) -> tuple[float, float]:
    """Processor seconds and peak MiB of a process."""
    return ended(start(words))


def start(words: tuple[str, ...], core: int | None = None, **pipes) -> subprocess.Popen:
    """A process, on one core alone if that is told, that is silent but for these `pipes`."""
    pin = None if core is None else lambda: os.sched_setaffinity(0, {core})
    pipes = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL, **pipes}
    return subprocess.Popen(words, preexec_fn=pin, **pipes)


def ended(process: subprocess.Popen) -> tuple[float, float]:
    """Processor seconds and peak MiB of a process that was started, once it ended."""
    _, status, used = os.wait4(process.pid, 0)
    assert status == 0, process.args
    return used.ru_utime + used.ru_stime, used.ru_maxrss / 1024


LARGE = """
import sys, fogbow
image = fogbow.render({smoke!r}, rays=1, photons=1000, size=(4096, 4096))
kept = [image.rgb, image.alpha, *image.layers.values()] if {takes} else []
assert sum(values.nbytes for values in kept) >= {takes} * 12 * 4 * 4096**2
assert all(values.base is not None for values in kept)
"""


def memory() -> None:
    peaks = {}
    for takes in (0, 1):
        code = LARGE.format(smoke=str(SMOKE), takes=takes)
        peaks[takes] = child(sys.executable, "-c", code)[1]
        print(f"peak memory with {takes and 'all' or 'no'} arrays taken: {peaks[takes]:.0f} MiB")
    one = 4 * 4096**2 / 2**20
    assert abs(peaks[1] - peaks[0]) < one, f"a layer takes {one:.0f} MiB"


WORKER = """
import sys, time, fogbow
for _ in sys.stdin:
    start = time.process_time()
    fogbow.render({smoke!r}, **{settings!r}).save({exr!r}, {png!r})
    print(time.process_time() - start, flush=True)
"""


def timed(program: str, ratios: str = "160") -> None:
    """Renders by the module beside those by the program, whose build must be of the same profile.

    Both run at once, on a core each that they change every time, so that other programs slow both alike. A ratio is that
    of two such pairs. What starting Python and importing the module take is counted in each render by the module.
    """
    settings = {"rays": 16, "photons": 200_000, "size": (256, 256)}
    flags = ["--rays=16", "--photons=200000", "--size=256x256", "--quiet"]
    cores = sorted(os.sched_getaffinity(0))[:2]
    assert len(cores) == 2, "two cores are needed"
    imported = statistics.median(child(sys.executable, "-c", "import fogbow")[0] for _ in range(9))
    print(f"importing the module takes {imported:.2f} s")
    logs = []
    with tempfile.TemporaryDirectory() as folder:
        call = (program, "render", str(SMOKE), "-o", f"{folder}/b.exr", *flags)
        code = WORKER.format(smoke=str(SMOKE), settings=settings, exr=f"{folder}/a.exr", png=f"{folder}/a.png")
        workers = {core: worker(code, core) for core in cores}
        for core in cores:
            rendered(workers[core])
        for _ in range(int(ratios)):
            pair = []
            for core, other in (cores, cores[::-1]):
                process = start(call, other)
                module = imported + rendered(workers[core])
                command, _ = ended(process)
                pair.append(math.log(module / command))
            logs.append(statistics.mean(pair))
            print(f"{module:.2f} s beside {command:.2f} s: {math.exp(logs[-1]):.4f}", flush=True)
        for process in workers.values():
            process.communicate()
    # Of logarithms, so that it does not matter which of both is over the other.
    half = 2.0 * statistics.stdev(logs) / len(logs) ** 0.5  # Student's t, 60 degrees of freedom or more, 95 %
    low, mean, high = (math.exp(statistics.mean(logs) + by) for by in (-half, 0, half))
    print(f"processor time over that of the command: {mean:.4f}, 95 % interval {low:.4f} to {high:.4f}")
    assert high < 1.02


def worker(code: str, core: int) -> subprocess.Popen:
    """A Python on one core that runs `code`, which renders for each line that it reads."""
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "text": True}
    return start((sys.executable, "-c", code), core, **pipes)


def rendered(process: subprocess.Popen) -> float:
    """Processor seconds of one render of a `worker`."""
    process.stdin.write("render\n")
    process.stdin.flush()
    return float(process.stdout.readline())


def beside(name: str) -> None:
    for order in ((name, "fogbow"), ("fogbow", name)):
        subprocess.run([sys.executable, __file__, "both", *order], check=True)
        print(f"{order[0]}, then {order[1]}: both render")


def both(*names: str) -> None:
    modules = {name: __import__(name) for name in names}
    for name in (*names, *names):
        {"fogbow": with_fogbow, "bpy": with_bpy, "mitsuba": with_mitsuba}[name](modules[name])


def with_fogbow(fogbow) -> None:
    image = fogbow.render(VOLUMES / "smoke.vdb", rays=1, photons=1000, size=(32, 18))
    assert image.rgb.max() > 0


def with_bpy(bpy) -> None:
    with tempfile.TemporaryDirectory() as folder:
        bpy.ops.wm.read_factory_settings(use_empty=True)
        bpy.ops.object.volume_import(filepath=str(VOLUMES / "smoke.vdb"))
        bpy.ops.object.light_add(type="SUN")
        bpy.ops.object.camera_add(location=(0, -9, 2), rotation=(1.5, 0, 0))
        scene = bpy.context.scene
        scene.camera = bpy.context.object
        scene.render.engine = "CYCLES"
        scene.cycles.samples = 1
        scene.render.resolution_x, scene.render.resolution_y = 32, 18
        scene.render.filepath = f"{folder}/a.png"
        bpy.ops.render.render(write_still=True)
        assert os.path.getsize(f"{folder}/a.png") > 0


def with_mitsuba(mitsuba) -> None:
    mitsuba.set_variant("scalar_rgb")
    scene = mitsuba.load_dict(mitsuba.cornell_box())
    import numpy as np

    assert np.array(mitsuba.render(scene, spp=1)).max() > 0


if __name__ == "__main__":
    jobs = {"notebooks": notebooks, "arrays": arrays, "memory": memory, "time": timed, "beside": beside, "both": both}
    jobs[sys.argv[1]](*sys.argv[2:])
