"""`ipoa-mission` and `python -m ipoa_mission`: the command line, and Ctrl-C while it is still being imported."""

import sys


def main() -> None:
    """Run the command line."""
    try:
        import gc
        import os

        gc.set_threshold(50_000)  # imports make many objects, and no garbage
        os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")  # to look for any it reads all that is installed
        os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # its threads take longer to start than matrices to solve
        from ipoa_mission.cli.app import main as run

        run()
    except KeyboardInterrupt:
        if "--json" in sys.argv[1:]:
            print('{"error": "stopped: nothing was done", "hint": null, "exit_code": 130}')
        print("error: stopped: nothing was done", file=sys.stderr)
        sys.exit(130)


if __name__ == "__main__":
    main()
