"""A general language model as a reasoner: prompt, chain of thought and function calling, zero-shot."""

from stucksolver.reason.llm.answer import AnswerError, parse_answer
from stucksolver.reason.llm.budget import Budget, BudgetSpent, Price, Purse
from stucksolver.reason.llm.chat import ChatModel, GiveUp, Message, Reply, Tool, ToolCall, TryAgain, Usage
from stucksolver.reason.llm.reasoner import LanguageModelReasoner, ModelSettings

__all__ = [
    "AnswerError",
    "Budget",
    "BudgetSpent",
    "ChatModel",
    "GiveUp",
    "LanguageModelReasoner",
    "Message",
    "ModelSettings",
    "Price",
    "Purse",
    "Reply",
    "Tool",
    "ToolCall",
    "TryAgain",
    "Usage",
    "parse_answer",
]
