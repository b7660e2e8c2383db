"""What an evaluation says of itself."""

from __future__ import annotations

from pathlib import Path

import pytest

pytest.importorskip("carla")

from stucksolver_eval.runner.evaluate import EvaluationSpec, manifest_of
from stucksolver_eval.systems.spec import SystemSpec
from stucksolver_language.llm.prompt import prompt_name


@pytest.mark.parametrize(
    ("arm", "prompt"),
    [
        (SystemSpec(recovery="search"), ""),
        (SystemSpec(recovery="openai:gpt-4o"), prompt_name()),
        (SystemSpec(recovery="search", reasoner="openai:gpt-4o"), prompt_name()),
    ],
)
def test_the_prompts_version_stands_where_a_model_is_asked(arm: SystemSpec, prompt: str) -> None:
    assert manifest_of(EvaluationSpec(suite="dev", out=Path("out"), arm=arm), ()).prompt == prompt
