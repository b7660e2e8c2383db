"""The HTTP side of the model server: three addresses behind the doors of the passenger's page, with limits of its own.

There is no token: it answers programs on this machine, and whoever may reach another address that the user names. So
pages of other sites are kept out, and nobody can fill its memory or hold its connections for long.
"""

from __future__ import annotations

import json
import logging
from typing import Any

from fastapi import FastAPI, Request
from fastapi.concurrency import run_in_threadpool
from fastapi.responses import JSONResponse
from starlette.exceptions import HTTPException

from stucksolver.passenger.server.doors import Doors, Refused
from stucksolver.passenger.server.places import PlaceLimits
from stucksolver.serve.completions import MODEL, RequestError, Student

LARGEST_BYTES = 1_000_000
"""Largest request: a prompt has some 20 kB, and a picture of 800 x 450 pixels as base64 some 130 kB. The student looks
at no picture.
"""
SMALLER = "Send a smaller picture, or none: the student looks at none (#pictures=off)."
PLACES = PlaceLimits(waiting=32)
"""Connections at once. Each holds at most one body, so that all bodies together stay below 32 MB."""
CONTEXT_TOKENS = 32_768
"""Stated context. The student reads scenes of any length, and answers in at most 60 codes."""
log = logging.getLogger(__name__)


def behind_doors(app: FastAPI, hosts: frozenset[str]) -> Doors:
    """Return the application behind checks of host, origin, content type and size, which are those of the page.

    Args:
        app: The application.
        hosts: `HOST:PORT` of each address at which it may be asked.
    """
    return Doors(app, hosts, "http", own="/", body_bytes=LARGEST_BYTES, told=_in_openais_form)


def _in_openais_form(refused: Refused) -> tuple[bytes, bytes]:
    more = f" {SMALLER}" if refused.status == 413 else ""
    return b"application/json", json.dumps(RequestError(refused.why + more, status=refused.status).body).encode()


def make_app(student: Student) -> FastAPI:
    """Return the application that serves a student; to be used behind doors, which limit what is sent."""
    app = FastAPI(title="stucksolver serve-model", docs_url=None, redoc_url=None, openapi_url=None)

    @app.get("/v1/models")
    async def models() -> dict[str, Any]:
        entry = {"id": MODEL, "object": "model", "created": 0, "owned_by": "stucksolver"}
        return {"object": "list", "data": [entry | {"max_model_len": CONTEXT_TOKENS}]}

    @app.get("/health")
    async def health() -> dict[str, str]:
        return {"status": "ok"}

    @app.post("/v1/chat/completions")
    async def completions(request: Request) -> JSONResponse:
        return JSONResponse(await run_in_threadpool(student.complete, await request.body()))

    @app.exception_handler(RequestError)
    async def wrong(request: Request, error: RequestError) -> JSONResponse:
        return JSONResponse(error.body, error.status)

    @app.exception_handler(HTTPException)
    async def not_served(request: Request, error: HTTPException) -> JSONResponse:
        said = f"{request.method} {request.url.path}: {error.detail}; POST to /v1/chat/completions"
        return JSONResponse(RequestError(said, status=error.status_code).body, error.status_code)

    @app.exception_handler(Exception)
    async def failed(request: Request, error: Exception) -> JSONResponse:
        log.error("a request failed", exc_info=error)
        return JSONResponse(RequestError("the server failed; its log has the reason", status=500).body, 500)

    return app
