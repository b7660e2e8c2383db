"""A general language model as a reasoner: prompt, chain of thought and function call, without training examples."""

from stucksolver_language.llm.answer_parser import AnswerError, parse_answer
from stucksolver_language.llm.chat import (
    ChatModel,
    ChatReply,
    Message,
    PermanentReasonerError,
    Tool,
    ToolCall,
    TransientReasonerError,
    Usage,
)
from stucksolver_language.llm.llm_reasoner import LanguageModelReasoner, ModelSettings
from stucksolver_language.llm.usage_budget import BudgetExceededError, Price, UsageLimits

__all__ = [
    "AnswerError",
    "BudgetExceededError",
    "ChatModel",
    "ChatReply",
    "LanguageModelReasoner",
    "Message",
    "ModelSettings",
    "PermanentReasonerError",
    "Price",
    "Tool",
    "ToolCall",
    "TransientReasonerError",
    "Usage",
    "UsageLimits",
    "parse_answer",
]
