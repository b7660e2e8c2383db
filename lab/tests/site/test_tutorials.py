"""The tutorial's runner: what a page says is done, and a page that is wrong is found."""

from __future__ import annotations

import pytest

from lab.docsite.tutorials import PAGES, TutorialError, blocks, checkout, follow


def done(text: str, folder) -> list[str]:
    return list(follow(text, folder))


def test_files_are_written_and_commands_run_in_order(tmp_path):
    file = '```python title="a/b.py"\nprint("hello")\n```\n\n'
    page = file + '```sh\npython a/b.py\n```\n\n```text title="prints"\nhello\n```\n'
    assert done(page, tmp_path) == ["python a/b.py\n"]


@pytest.mark.parametrize(
    ("page", "told"),
    [
        ("```sh\nfalse\n```\n", "exit code 1"),
        ("```sh\nno-such-program-here\n```\n", "exit code 127"),
        ('```sh\necho one\n```\n\n```text title="prints"\ntwo\n```\n', "not printed: 'two'"),
    ],
)
def test_tutorial_page_that_fails_is_reported(tmp_path, page, told):
    """A page whose commands fail, or whose output differs, raises an error that names the cause."""
    with pytest.raises(TutorialError, match=told):
        done(page, tmp_path)


def test_each_page_of_the_tutorial_has_commands_to_run():
    pages = [page for page in PAGES.glob("*.md") if page.stem != "index"]
    assert len(pages) == 5
    for page in pages:
        assert any(block.language == "sh" for block in blocks(page.read_text(encoding="utf-8"))), page.name


@pytest.mark.integration
@pytest.mark.parametrize("name", ["own-stack", "own-behavior"])
def test_the_pages_that_need_no_simulator_do_what_they_say(tmp_path, name):
    checkout(tmp_path)
    assert done((PAGES / f"{name}.md").read_text(encoding="utf-8"), tmp_path)
