"""The HTTP side of the model server: three addresses, a limit of size, and errors in OpenAI's form."""

from __future__ import annotations

import logging
from typing import Any

from fastapi import FastAPI, Request
from fastapi.concurrency import run_in_threadpool
from fastapi.responses import JSONResponse
from starlette.exceptions import HTTPException

from stucksolver.serve.completions import MODEL, RequestError, Student

LARGEST_BYTES = 20_000_000
"""Largest request: a prompt has some 20 kB, and its picture at most 5 MB."""
CONTEXT_TOKENS = 32_768
"""Stated context. The student reads scenes of any length, and answers in at most 60 codes."""
log = logging.getLogger(__name__)


def make_app(student: Student) -> FastAPI:
    """Return the application that serves a student."""
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
        body = await _body(request)
        return JSONResponse(await run_in_threadpool(student.complete, body))

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


async def _body(request: Request) -> bytes:
    """Return the body of a request. Raises `RequestError` if it is too large."""
    body = bytearray()
    async for part in request.stream():
        body += part
        if len(body) > LARGEST_BYTES:
            raise RequestError(f"the request has more than {LARGEST_BYTES} bytes: send a smaller picture", status=413)
    return bytes(body)
