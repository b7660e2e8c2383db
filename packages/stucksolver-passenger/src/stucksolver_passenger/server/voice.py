"""Serves the speech recognizer to the browser, if one is installed on this machine."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from fastapi import FastAPI, HTTPException
from fastapi.responses import FileResponse

from stucksolver_passenger.speech_recognizer import FILES, Recognizer

TYPES = {
    ".js": "text/javascript",
    ".mjs": "text/javascript",
    ".wasm": "application/wasm",
    ".onnx": "application/octet-stream",
    ".txt": "text/plain",
}


def add_voice(app: FastAPI, recognizer: Recognizer | None) -> None:
    """`/voice` says whether there is one. Its files are served under their version, so that browsers may cache them."""

    @app.get("/voice", include_in_schema=False)
    async def voice() -> dict[str, Any]:
        return {"version": None if recognizer is None else recognizer.version}

    @app.get("/voice/{version}/{name}", include_in_schema=False)
    async def file(version: str, name: str) -> FileResponse:
        if recognizer is None or version != recognizer.version or name not in FILES:
            raise HTTPException(404, "There is no such file.")
        return FileResponse(recognizer.folder / name, media_type=TYPES[Path(name).suffix])
