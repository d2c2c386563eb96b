"""Ask kept inputs again and print their answers.

Usage: python tests/fuzz/again.py FILE.json...
"""

import sys
from pathlib import Path

sys.path[:0] = [str(Path(__file__).parents[1] / "helpers"), str(Path(__file__).parents[2])]

from answering import Responder
from kinds import judge
from question import Question

if __name__ == "__main__":
    with Responder() as responder:
        for file in sys.argv[1:]:
            question = Question.from_json(Path(file).read_text())
            answer = responder.ask(question)
            print(f"{file}: {judge(question, answer) or 'well'}")
            print(f"  {question.call}\n  {answer}"[:3000])
