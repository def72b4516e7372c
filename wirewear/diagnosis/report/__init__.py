"""The answer: values, sentences, pictures and the page."""
