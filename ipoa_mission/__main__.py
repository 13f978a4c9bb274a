"""Run the command line as `ipoa-mission` or `python -m ipoa_mission`; handle Ctrl-C during its imports."""

import sys


def main() -> None:
    try:
        import atexit
        import gc
        import os

        gc.set_threshold(200_000)  # imports make no garbage
        atexit.register(gc.freeze)  # else exit visits all objects
        os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")  # its search reads all installed packages
        os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # threads take longer than the matrices here

        from ipoa_mission.cli.app import main as run

        run()
    except KeyboardInterrupt:
        if "--json" in sys.argv[1:]:
            print('{"error": "stopped: nothing was done", "hint": null, "exit_code": 130}')
        print("error: stopped: nothing was done", file=sys.stderr)
        sys.exit(130)


if __name__ == "__main__":
    main()
