"""The command `tgpo-studio`: the page, or training and evaluation without it.

Everything heavy is imported after the arguments have been read, so that errors in them answer at
once; `--help` asks the robots for their variants, which takes a second.
"""

import os
import sys
from collections.abc import Sequence

import tyro

from core.errors import UserError
from studio.options import Options, chosen_action

BAD_INPUT = 2
"""Exit status of arguments, scenes, formulas or files that cannot be used."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; returns its exit status (argument errors raise SystemExit(2))."""
    options = tyro.cli(
        Options,
        prog="tgpo-studio",
        args=arguments,
        config=(tyro.conf.FlagCreatePairsOff,),
    )
    try:
        return _run(chosen_action(options), options)
    except UserError as error:
        print(f"error: {error}", file=sys.stderr)
        return BAD_INPUT
    except KeyboardInterrupt:
        print("aborted", file=sys.stderr)
        return 130
    except BrokenPipeError:  # the reader of our output has closed it
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 1


def _run(action: str, options: Options) -> int:
    if action == "page":
        return _serve(options)
    from studio.runs import commands, planning  # noqa: PLC0415

    if action == "list":
        return commands.list_tasks()
    if action == "explain":
        from studio.runs.explaining import explain  # noqa: PLC0415

        return explain(options)
    if action == "exact":
        from studio.runs.exact import plan_exact  # noqa: PLC0415

        return plan_exact(options)
    if action == "new":
        from studio.runs.beginning import begin  # noqa: PLC0415

        return begin(options)
    _use_cache(options)
    actions = {
        "evaluate": commands.evaluate,
        "plan": planning.plan,
        "pretrain": commands.pretrain,
        "resume": commands.resume,
        "train_only": commands.train_only,
    }
    return actions[action](options)


def _serve(options: Options) -> int:
    from studio.page.app import serve  # noqa: PLC0415

    _use_cache(options)
    serve(
        task=options.task,
        scene=None if options.scene is None else str(options.scene),
        formula=options.formula,
        host=options.host,
        port=options.port,
        open_browser=not options.no_browser,
        load=options.load,
        token=options.token,
    )
    return 0


def _use_cache(options: Options) -> None:
    from core.compilation import use_disk_cache  # noqa: PLC0415

    if not options.no_cache:
        use_disk_cache()
