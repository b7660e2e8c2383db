"""The page itself: files of the package, and the scripts that draw the view from above."""

from __future__ import annotations

from importlib import resources
from pathlib import Path
from typing import Any

from fastapi import FastAPI, HTTPException, Response
from fastapi.responses import FileResponse

from stucksolver_passenger.speech_recognizer import FILES, Recognizer

RECOGNIZER_TYPES = {
    ".js": "text/javascript",
    ".mjs": "text/javascript",
    ".wasm": "application/wasm",
    ".onnx": "application/octet-stream",
    ".txt": "text/plain",
}


def add_voice(app: FastAPI, recognizer: Recognizer | None) -> None:
    """Add the route `/voice`, which returns whether there is a recognizer, and the routes of its files.

    The paths of the files contain their version, so that browsers may cache them.
    """

    @app.get("/voice", include_in_schema=False)
    async def voice() -> dict[str, Any]:
        return {"version": None if recognizer is None else recognizer.version}

    @app.get("/voice/{version}/{name}", include_in_schema=False)
    async def file(version: str, name: str) -> FileResponse:
        if recognizer is None or version != recognizer.version or name not in FILES:
            raise HTTPException(404, "There is no such file.")
        return FileResponse(recognizer.folder / name, media_type=RECOGNIZER_TYPES[Path(name).suffix])


TYPES = {".html": "text/html", ".css": "text/css", ".js": "text/javascript", ".svg": "image/svg+xml"}
DRAWING = ("dom.js", "decode.js", "palette.js", "camera.js", "scene.js", "palette.css")
"""Scripts that draw the replays of reports. The page uses the same scripts live."""


def add_pages(app: FastAPI, drawing: Path | None) -> None:
    """Serve the page. All its files are read at the start, so a file that is added later is not served."""
    files = _own() | ({} if drawing is None else _drawing(drawing))

    @app.get("/", include_in_schema=False)
    async def page() -> Response:
        return _served("index.html", files)

    @app.get("/docs", include_in_schema=False)
    async def docs() -> Response:
        return _served("docs.html", files)

    @app.get("/files/{name}", include_in_schema=False)
    async def file(name: str) -> Response:
        return _served(name, files)


def _own() -> dict[str, bytes]:
    folder = resources.files("stucksolver_passenger") / "web"
    return {path.name: path.read_bytes() for path in folder.iterdir() if Path(path.name).suffix in TYPES}


def _drawing(folder: Path) -> dict[str, bytes]:
    return {name: (folder / name).read_bytes() for name in DRAWING}


def _served(name: str, files: dict[str, bytes]) -> Response:
    if name not in files:
        raise HTTPException(404, "There is no such file.")
    return Response(files[name], media_type=f"{TYPES[Path(name).suffix]}; charset=utf-8")
