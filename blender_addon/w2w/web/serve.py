# SPDX-License-Identifier: GPL-3.0-or-later
"""`w2w serve`: the web app."""

import secrets
from errno import EADDRINUSE
from pathlib import Path
from socket import AF_INET, AF_INET6, create_server
from typing import TYPE_CHECKING, Annotated

import typer

from ..core.files import write_text
from ..core.wording import count
from ..headless.console import BUSY, NOTHING_TO_DO, USAGE, Terminal, sentence_of
from ..headless.options import option

if TYPE_CHECKING:
    from .guard import Doors
    from .work import Work

MEGABYTE = 10**6


def serve(
    data: Annotated[Path, option("Folder for all studies; made if missing.")] = Path("w2w_studies"),
    port: Annotated[int, option("Port to listen on.", min=1, max=65535)] = 8000,
    host: Annotated[
        str, option("Address to listen on; 0.0.0.0 lets other machines in, with a token.")
    ] = "127.0.0.1",
    name: Annotated[
        list[str] | None, option("A further name by which browsers reach it, as behind a proxy; repeatable.")
    ] = None,
    token: Annotated[
        list[str] | None,
        option(
            "Token to come in with; each of several sees its own studies only. Whoever lists this machine's "
            "processes sees it: better set W2W_TOKEN, or invite people.  [default: one is drawn and kept in "
            "the data folder, unless only this machine can come in]",
            envvar="W2W_TOKEN",
            show_default=False,
        ),
    ] = None,
    invite: Annotated[
        str, option("Draw a token for a person, print their link, and end; the server may be running.")
    ] = "",
    workers: Annotated[int, option("Studies worked on at the same time.", min=1)] = 1,
    scheduler: Annotated[str, option("Dask scheduler for the runs, as for 'w2w run'.")] = "",
    most_mb: Annotated[
        int, option("Most MB of a study's files; three times that of a person's, ten times in all.", min=1)
    ] = 2000,
    keep_days: Annotated[float, option("Days after which an unused study is deleted.", min=0.01)] = 30.0,
) -> None:
    """Serve W2W as a web app: drop clips in a browser, get the answer.

    Needs the extra 'web'. Studies lie in the data folder: a server that is started again goes on there.

    Exit codes: 0 stopped, 1 libraries are missing, 2 wrong use, 4 another server uses the data folder.
    """
    console = Terminal()
    try:
        import uvicorn
        from filelock import FileLock, Timeout

        from .app import web_app
        from .connections import AT_ONCE, with_room
        from .guard import Doors, People, is_local
        from .work import Work
    except ImportError as error:
        console.print(f"{error}. In W2W's source folder: pip install '.[web]'", style="red")
        raise typer.Exit(NOTHING_TO_DO) from error
    tokens = list(token or ())
    if any(len(one) < 8 or not one.isascii() or " " in one for one in tokens):
        console.print("--token needs at least 8 letters, digits or signs, without spaces", style="red")
        raise typer.Exit(USAGE)
    address = f"http://{f'[{host}]' if ':' in host else host}:{port}/"
    people = People(data.absolute() / "people")
    try:
        data.mkdir(0o700, parents=True, exist_ok=True)
        if invite:
            console.print(f"{invite} comes in by {address}#token={people.invite(invite)}", soft_wrap=True)
            return
        lock = FileLock(data / "lock")
        lock.acquire(timeout=0)
        create_server((host, port), family=AF_INET6 if ":" in host else AF_INET).close()
    except (OSError, ValueError, Timeout) as error:
        busy, taken = isinstance(error, Timeout), getattr(error, "errno", 0) == EADDRINUSE
        other = f"{address} is taken by another program: give another --port" if taken else sentence_of(error)
        console.print(f"Another server uses {data}" if busy else other, style="red")
        raise typer.Exit(BUSY if busy else USAGE) from error
    if not tokens and not people and not (is_local(host) and not name):
        tokens = [_kept_token(data / "token")]
    asked = f"#token={tokens[0]}" if tokens and not token else ""
    console.print(f"W2W is at {address}{asked}", soft_wrap=True)
    doors = Doors(host, [each.lower() for each in name or ()], tokens, most_mb * MEGABYTE, people)
    work = Work(data.absolute(), workers, scheduler, keep_days)
    if hidden := unseen(work, doors):
        console.print(
            f"{hidden}: nobody sees them now. Invite that person, or give that token, again.", style="yellow"
        )
    uvicorn.run(
        web_app(work, doors), host=host, port=port, log_level="warning", access_log=False,
        server_header=False, timeout_graceful_shutdown=2, http=with_room(), backlog=AT_ONCE,
    )  # fmt: skip


def unseen(work: "Work", doors: "Doors") -> str:
    """How many studies in a data folder belong to nobody who can come in, in words; "" if none does."""
    from .guard import folder_of, folder_of_person

    owners = {*map(folder_of, doors.tokens), *map(folder_of_person, doors.people.hashes())}
    others = [study for study in work.studies() if study.folder.parent.name not in (owners or {"local"})]
    return (
        f"{count('study', len(others))} in {work.data} {'is' if len(others) == 1 else 'are'} of another token"
        if others
        else ""
    )


def _kept_token(path: Path) -> str:
    """The token of a data folder, drawn once, which only its owner can read."""
    if not path.exists():
        write_text(path, secrets.token_urlsafe(24))
        path.chmod(0o600)
    return path.read_text(encoding="utf-8").strip()
